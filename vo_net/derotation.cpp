#include "vo_net/derotation.hpp"

#include <algorithm>
#include <cmath>

#include "slam/lie/so3.hpp"

namespace imslam::vo {
namespace {

using nn::Index;
using nn::Var;

constexpr double kLeastDepth = 0.1;  // of a turned ray: below it leaves any image
constexpr double kShortest = 1e-6;   // [focal lengths], far below any matcher's noise

template <typename S>
using Vector3 = Eigen::Matrix<S, 3, 1>;

template <typename S>
Vector3<S> row3(const S* numbers, Index row) {
  return {numbers[3 * row], numbers[3 * row + 1], numbers[3 * row + 2]};
}

template <typename S>
void add_row3(S* numbers, Index row, const Vector3<S>& v) {
  for (Index i = 0; i < 3; ++i) numbers[3 * row + i] += v[i];
}

/// The ray at which a cell's point is seen later.
template <typename S>
Vector3<S> later_ray(const S* flow, const S* place) {
  return {place[0] + flow[0], place[1] + flow[1], S(1)};
}

void expect_fields(const nn::Shape& flow, const nn::Shape& confidence) {
  nn::expects_shapes(flow.rank() == 4 && flow[3] == 2 && confidence == flow.with_channels(1),
                     "flow field: flow [N,H,W,2] and confidence [N,H,W,1]", flow, confidence);
}

}  // namespace

template <typename S>
Var derotate(nn::Tape<S>& tape, Var flow, Var place, Var confidence, Var theta) {
  const nn::Shape shape = tape.shape(flow);
  expect_fields(shape, tape.shape(confidence));
  nn::expects_shapes(tape.shape(theta) == nn::Shape{shape[0], 3} && tape.shape(place) == shape,
                     "derotate: flow [N,H,W,2] and theta [N,3]", shape, tape.shape(theta));
  const Index samples = shape[0];
  const Index cells = shape[1] * shape[2];
  const Var y = tape.make(shape);
  for (Index n = 0; n < samples; ++n) {
    const auto R = lie::SO3<S>::exp(row3(tape.data(theta), n)).matrix();
    for (Index i = n * cells; i < (n + 1) * cells; ++i) {
      const S* const x = tape.data(place) + 2 * i;
      const Vector3<S> g = R * later_ray(tape.data(flow) + 2 * i, x);
      const bool seen = tape.data(confidence)[i] > S(0) && g.z() > S(kLeastDepth);
      tape.data(y)[2 * i] = seen ? g.x() / g.z() - x[0] : S(0);
      tape.data(y)[2 * i + 1] = seen ? g.y() / g.z() - x[1] : S(0);
    }
  }
  return tape.record(y, {flow, theta}, [=](nn::Tape<S>& t) {
    S* const dflow = t.wants_gradient(flow) ? t.gradient_data(flow) : nullptr;
    S* const dtheta = t.wants_gradient(theta) ? t.gradient_data(theta) : nullptr;
    const S* const dy = t.gradient_data(y);
    for (Index n = 0; n < samples; ++n) {
      const Vector3<S> angle = row3(t.data(theta), n);
      const auto R = lie::SO3<S>::exp(angle).matrix();
      Vector3<S> turned = Vector3<S>::Zero();
      for (Index i = n * cells; i < (n + 1) * cells; ++i) {
        const Vector3<S> p = later_ray(t.data(flow) + 2 * i, t.data(place) + 2 * i);
        const Vector3<S> g = R * p;
        if (!(t.data(confidence)[i] > S(0) && g.z() > S(kLeastDepth))) continue;
        const S* const d = dy + 2 * i;
        const S along = (d[0] * g.x() + d[1] * g.y()) / g.z();
        const Vector3<S> dp = R.transpose() * Vector3<S>(d[0], d[1], -along) / g.z();
        if (dflow != nullptr) {
          dflow[2 * i] += dp.x();
          dflow[2 * i + 1] += dp.y();
        }
        turned += p.cross(dp);
      }
      if (dtheta != nullptr) {
        add_row3<S>(dtheta, n, lie::SO3<S>::right_jacobian(angle).transpose() * turned);
      }
    }
  });
}

template <typename S>
Var compose_rotations(nn::Tape<S>& tape, Var first, Var second) {
  const nn::Shape shape = tape.shape(first);
  nn::expects_shapes(shape.channels() == 3 && tape.shape(second) == shape,
                     "compose_rotations: two [N,3]", shape, tape.shape(second));
  const Var y = tape.make(shape);
  for (Index n = 0; n < shape.rows(); ++n) {
    const auto R =
        lie::SO3<S>::exp(row3(tape.data(second), n)) * lie::SO3<S>::exp(row3(tape.data(first), n));
    const Vector3<S> both = R.log();
    std::copy_n(both.data(), 3, tape.data(y) + 3 * n);
  }
  return tape.record(y, {first, second}, [=](nn::Tape<S>& t) {
    using SO3 = lie::SO3<S>;
    const S* const dy = t.gradient_data(y);
    for (Index n = 0; n < t.shape(y).rows(); ++n) {
      const Vector3<S> w1 = row3(t.data(first), n);
      const Vector3<S> w2 = row3(t.data(second), n);
      const Vector3<S> d =
          SO3::right_jacobian_inverse(row3(t.data(y), n)).transpose() * row3(dy, n);
      if (t.wants_gradient(first)) {
        add_row3<S>(t.gradient_data(first), n, SO3::right_jacobian(w1).transpose() * d);
      }
      if (t.wants_gradient(second)) {
        const Vector3<S> turned = SO3::exp(w1).matrix() * d;
        add_row3<S>(t.gradient_data(second), n, SO3::right_jacobian(w2).transpose() * turned);
      }
    }
  });
}

template <typename S>
Var median_length(nn::Tape<S>& tape, Var flow, Var confidence) {
  const nn::Shape shape = tape.shape(flow);
  expect_fields(shape, tape.shape(confidence));
  const Index samples = shape[0];
  const Index cells = shape[1] * shape[2];
  const Var y = tape.make({samples, 1, 1, 1});
  Index* const middle_cell = tape.template keep<Index>(samples);
  const auto square = [&tape, flow](Index i) {
    const S* const f = tape.data(flow) + 2 * i;
    return f[0] * f[0] + f[1] * f[1];
  };
  {
    nn::Scratch<S> scratch(tape);
    Index* const seen = scratch.template array<Index>(cells);
    for (Index n = 0; n < samples; ++n) {
      Index* end = seen;
      for (Index i = n * cells; i < (n + 1) * cells; ++i) {
        if (tape.data(confidence)[i] > S(0)) *end++ = i;
      }
      Index* const middle = seen + (end - seen) / 2;
      // The cell's number decides among equals: the same cell whatever the library's algorithm.
      std::nth_element(seen, middle, end, [&](Index a, Index b) {
        return square(a) != square(b) ? square(a) < square(b) : a < b;
      });
      middle_cell[n] = end == seen ? -1 : *middle;
      const S length_sq = end == seen ? S(0) : square(*middle);
      tape.data(y)[n] = std::sqrt(length_sq + S(kShortest * kShortest));
    }
  }
  return tape.record(y, {flow}, [=](nn::Tape<S>& t) {
    for (Index n = 0; n < samples; ++n) {
      if (middle_cell[n] < 0) continue;
      const S slope = t.gradient_data(y)[n] / t.data(y)[n];
      for (Index k = 2 * middle_cell[n]; k < 2 * middle_cell[n] + 2; ++k) {
        t.gradient_data(flow)[k] += slope * t.data(flow)[k];
      }
    }
  });
}

#define INSTANTIATE(S)                                     \
  template Var derotate(nn::Tape<S>&, Var, Var, Var, Var); \
  template Var compose_rotations(nn::Tape<S>&, Var, Var);  \
  template Var median_length(nn::Tape<S>&, Var, Var);
INSTANTIATE(float)
INSTANTIATE(double)

}  // namespace imslam::vo
