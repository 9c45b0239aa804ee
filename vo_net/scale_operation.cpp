#include "vo_net/scale_operation.hpp"

namespace imslam::vo {
namespace {

using nn::Index;
using nn::Var;

template <typename S>
Eigen::Vector3d vector_of(const nn::Tape<S>& tape, Var v) {
  const S* const x = tape.data(v);
  return {static_cast<double>(x[0]), static_cast<double>(x[1]), static_cast<double>(x[2])};
}

template <typename S>
Correspondences with_measured(const nn::Tape<S>& tape, Var measured, const Correspondences& from) {
  Correspondences result = from;
  if (!measured) return result;
  for (std::size_t k = 0; k < result.size(); ++k) {
    const S* const row = tape.data(measured) + 3 * k;
    result[k].left1 = {static_cast<double>(row[0]), static_cast<double>(row[1])};
    result[k].disparity0 = static_cast<double>(row[2]);
  }
  return result;
}

}  // namespace

template <typename S>
Var metric_translation(nn::Tape<S>& tape,
                       Var rotation,
                       Var direction,
                       Var measured,
                       const Correspondences& correspondences,
                       const StereoCamera& camera,
                       const ScaleOptions& options) {
  const auto count = static_cast<Index>(correspondences.size());
  nn::expects_shapes(
      tape.shape(rotation) == nn::Shape{1, 3} && tape.shape(direction) == tape.shape(rotation),
      "metric_translation: rotation and direction [1,3]", tape.shape(rotation),
      tape.shape(direction));
  if (measured) {
    nn::expects_shape(tape.shape(measured) == nn::Shape{count, 3},
                      "metric_translation: measured [P,3]", tape.shape(measured));
  }
  const Correspondences matches = with_measured(tape, measured, correspondences);
  const Eigen::Vector3d theta = vector_of(tape, rotation);
  const MotionDirection motion{lie::SO3d::exp(theta), vector_of(tape, direction)};
  const ScaleResult result = correct_scale(matches, camera, motion, options);
  const auto points = scale_gradient(matches, camera, motion, options, result);

  const Var y = tape.make({1, 3});
  for (int i = 0; i < 3; ++i) {
    tape.data(y)[i] = static_cast<S>(result.scale * motion.direction[i]);
  }
  double* const by_points = tape.template keep<double>(3 * count);
  for (Index k = 0; k < count; ++k) {
    const ScalePointGradient g =
        points ? (*points)[static_cast<std::size_t>(k)] : ScalePointGradient();
    by_points[3 * k] = g.left1.x();
    by_points[3 * k + 1] = g.left1.y();
    by_points[3 * k + 2] = g.disparity0;
  }
  struct Jacobian {
    std::array<double, 3> theta;
    std::array<double, 3> direction;
  } J{};
  const Eigen::Vector3d J_theta = lie::SO3d::right_jacobian(theta).transpose() * result.J_rotation;
  for (int i = 0; i < 3; ++i) {
    J.theta[static_cast<std::size_t>(i)] = J_theta[i];
    J.direction[static_cast<std::size_t>(i)] = result.J_direction[i];
  }
  const double scale = result.scale;
  return tape.record(y, {rotation, direction, measured}, [=](nn::Tape<S>& t) {
    const S* const dp = t.gradient_data(y);
    double ds = 0.0;
    for (int i = 0; i < 3; ++i) ds += static_cast<double>(dp[i] * t.data(direction)[i]);
    for (std::size_t i = 0; i < 3; ++i) {
      if (t.wants_gradient(direction)) {
        t.gradient_data(direction)[i] +=
            static_cast<S>(scale * static_cast<double>(dp[i]) + ds * J.direction[i]);
      }
      if (t.wants_gradient(rotation)) {
        t.gradient_data(rotation)[i] += static_cast<S>(ds * J.theta[i]);
      }
    }
    if (!t.wants_gradient(measured)) return;
    for (Index k = 0; k < 3 * count; ++k) {
      t.gradient_data(measured)[k] += static_cast<S>(ds * by_points[k]);
    }
  });
}

template Var metric_translation(nn::Tape<float>&,
                                Var,
                                Var,
                                Var,
                                const Correspondences&,
                                const StereoCamera&,
                                const ScaleOptions&);
template Var metric_translation(nn::Tape<double>&,
                                Var,
                                Var,
                                Var,
                                const Correspondences&,
                                const StereoCamera&,
                                const ScaleOptions&);

}  // namespace imslam::vo
