#include <algorithm>
#include <functional>
#include <type_traits>

#include "slam/base/parallel.hpp"
#include "slam/nn/kernels/instruction_set.hpp"
#include "slam/nn/ops/correlation.hpp"

namespace imslam::nn {
namespace {

template <typename S>
using Row = Eigen::Map<Eigen::Array<S, Eigen::Dynamic, 1>>;
template <typename S>
using ConstRow = Eigen::Map<const Eigen::Array<S, Eigen::Dynamic, 1>>;

struct Volume {
  Index samples, height, width, channels;
  Window window;

  /// Lines of pixels in parallel: each writes only its own.
  template <typename Line>
  void for_each_line(const Line& line) const {
    const auto body = [&](std::size_t i) { line(static_cast<Index>(i)); };
    parallel_for(static_cast<std::size_t>(samples * height), std::cref(body));
  }

  /// visit(k, pixel, other) for the pixels of one line and those `sign` d_k away from them, if
  /// inside.
  template <typename Visit>
  void for_each_partner(Index line, int sign, const Visit& visit) const {
    const Index row = line % height;
    const int rows = window.rows();
    const int columns = window.columns();
    for (Index j = 0; j < width; ++j) {
      for (int r = 0; r < rows; ++r) {
        const Index other_row = row + sign * (window.y_min + r * window.step);
        if (other_row < 0 || other_row >= height) continue;
        for (int c = 0; c < columns; ++c) {
          const Index column = j + sign * (window.x_min + c * window.step);
          if (column < 0 || column >= width) continue;
          visit(r * columns + c, line * width + j, (line - row + other_row) * width + column);
        }
      }
    }
  }
};

template <typename S>
void backward(Tape<S>& t, const Volume& v, Var a, Var b, Var y) {
  const Index C = v.channels;
  const Index K = v.window.count();
  const S* const dY = t.gradient_data(y);
  t.accumulate(a, [&](ArrayMap<S> dA) {
    const S* const B = t.data(b);
    v.for_each_line([&](Index line) {
      v.for_each_partner(line, 1, [&](int k, Index p, Index q) {
        Row<S>(dA.data() + p * C, C) += dY[p * K + k] * ConstRow<S>(B + q * C, C);
      });
    });
  });
  t.accumulate(b, [&](ArrayMap<S> dB) {
    const S* const A = t.data(a);
    v.for_each_line([&](Index line) {
      v.for_each_partner(line, -1, [&](int k, Index q, Index p) {
        Row<S>(dB.data() + q * C, C) += dY[p * K + k] * ConstRow<S>(A + p * C, C);
      });
    });
  });
}

/// One line of y; rows of the window are contiguous in b.
void fill_line(const Volume& v, Index line, const float* A, const float* B, float* Y) {
  const kernels::KernelTable& kernels = kernels::selected_kernels();
  const Index row = line % v.height;
  const int columns = v.window.columns();
  for (Index j = 0; j < v.width; ++j) {
    const Index first = std::max<Index>(0, j + v.window.x_min);
    const Index end = std::min(v.width, j + v.window.x_max + 1);
    const float* const query = A + (line * v.width + j) * v.channels;
    float* const y = Y + (line * v.width + j) * v.window.count();
    for (int r = 0; r < v.window.rows() && first < end; ++r) {
      const Index other = row + v.window.y_min + r;
      if (other < 0 || other >= v.height) continue;
      const float* const pixels = B + ((line - row + other) * v.width + first) * v.channels;
      kernels.dot_products(query, pixels, end - first, static_cast<int>(v.channels),
                           y + r * columns + (first - j - v.window.x_min));
    }
  }
}

}  // namespace

void Window::validate() const {
  expects(step >= 1 && x_max >= x_min && y_max >= y_min, "Window: step >= 1 and min <= max");
}

template <typename S>
Var cost_volume(Tape<S>& tape, Var a, Var b, const Window& window) {
  const Shape shape = tape.shape(a);
  window.validate();
  expects_shapes(shape.rank() == 4 && shape == tape.shape(b), "cost_volume: a and b [N,H,W,C]",
                 shape, tape.shape(b));
  const Volume v{shape[0], shape[1], shape[2], shape[3], window};
  const Index C = v.channels;
  const Var y = tape.make(shape.with_channels(window.count()));
  tape.array(y) = S(0);
  const S* const A = tape.data(a);
  const S* const B = tape.data(b);
  S* const Y = tape.data(y);
  const Index K = window.count();
  if constexpr (std::is_same_v<S, float>) {
    if (window.step == 1) {
      v.for_each_line([&](Index line) { fill_line(v, line, A, B, Y); });
      return tape.record(y, {a, b}, [=](Tape<S>& t) { backward(t, v, a, b, y); });
    }
  }
  v.for_each_line([&](Index line) {
    v.for_each_partner(line, 1, [&](int k, Index p, Index q) {
      Y[p * K + k] = (ConstRow<S>(A + p * C, C) * ConstRow<S>(B + q * C, C)).sum();
    });
  });
  return tape.record(y, {a, b}, [=](Tape<S>& t) { backward(t, v, a, b, y); });
}

#define INSTANTIATE(S) template Var cost_volume(Tape<S>&, Var, Var, const Window&);
IMSLAM_NN_FOR_EACH_SCALAR(INSTANTIATE)

}  // namespace imslam::nn
