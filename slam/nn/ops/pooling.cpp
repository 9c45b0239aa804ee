#include "slam/nn/ops/pooling.hpp"

#include "slam/nn/ops/reduce.hpp"

namespace imslam::nn {
namespace {

struct Windows {
  Index batch, in_height, in_width, channels, size, stride;

  Index out_height() const { return (in_height - size) / stride + 1; }
  Index out_width() const { return (in_width - size) / stride + 1; }
  Shape output() const { return {batch, out_height(), out_width(), channels}; }

  /// visit(at_x, at_y): offsets of the channels of a pixel of x and of the window that it is in.
  /// Windows in order, and in each the pixels in order.
  template <typename Visit>
  void for_each_pixel(const Visit& visit) const {
    Index at_y = 0;
    for (Index n = 0; n < batch; ++n) {
      for (Index i = 0; i < out_height(); ++i) {
        for (Index j = 0; j < out_width(); ++j, at_y += channels) {
          for (Index k = i * stride; k < i * stride + size; ++k) {
            for (Index l = j * stride; l < j * stride + size; ++l) {
              visit(((n * in_height + k) * in_width + l) * channels, at_y);
            }
          }
        }
      }
    }
  }
};

Windows windows(const Shape& x, int size, int stride) {
  expects_shape(x.rank() == 4 && size >= 1 && stride >= 1 && size <= x[1] && size <= x[2],
                "pooling: x [N,H,W,C] and a window inside of it", x);
  return {x[0], x[1], x[2], x[3], size, stride};
}

}  // namespace

template <typename S>
Var max_pool(Tape<S>& tape, Var x, int size, int stride) {
  const Windows w = windows(tape.shape(x), size, stride);
  const Var y = tape.make(w.output());
  Index* const from = tape.template keep<Index>(w.output().size());
  std::fill_n(from, w.output().size(), Index{-1});
  const S* const X = tape.data(x);
  w.for_each_pixel([&](Index at_x, Index at_y) {
    for (Index c = 0; c < w.channels; ++c) {
      Index& best = from[at_y + c];
      if (best < 0 || X[at_x + c] > X[best]) best = at_x + c;
    }
  });
  for (Index i = 0; i < w.output().size(); ++i) tape.data(y)[i] = X[from[i]];
  return tape.record(y, {x}, [=](Tape<S>& t) {
    const S* const dY = t.gradient_data(y);
    S* const dX = t.gradient_data(x);
    for (Index i = 0; i < w.output().size(); ++i) dX[from[i]] += dY[i];
  });
}

template <typename S>
Var average_pool(Tape<S>& tape, Var x, int size, int stride) {
  const Windows w = windows(tape.shape(x), size, stride);
  const S share = S(1.0 / static_cast<double>(w.size * w.size));
  const Var y = tape.make(w.output());
  tape.array(y) = S(0);
  const S* const X = tape.data(x);
  S* const Y = tape.data(y);
  w.for_each_pixel([&](Index at_x, Index at_y) {
    for (Index c = 0; c < w.channels; ++c) Y[at_y + c] += share * X[at_x + c];
  });
  return tape.record(y, {x}, [=](Tape<S>& t) {
    const S* const dY = t.gradient_data(y);
    S* const dX = t.gradient_data(x);
    w.for_each_pixel([&](Index at_x, Index at_y) {
      for (Index c = 0; c < w.channels; ++c) dX[at_x + c] += share * dY[at_y + c];
    });
  });
}

template <typename S>
Var global_max_pool(Tape<S>& tape, Var x) {
  return maximum(tape, x, {1, 2});
}

template <typename S>
Var global_average_pool(Tape<S>& tape, Var x) {
  return mean(tape, x, {1, 2});
}

#define INSTANTIATE(S)                                \
  template Var max_pool(Tape<S>&, Var, int, int);     \
  template Var average_pool(Tape<S>&, Var, int, int); \
  template Var global_max_pool(Tape<S>&, Var);        \
  template Var global_average_pool(Tape<S>&, Var);
IMSLAM_NN_FOR_EACH_SCALAR(INSTANTIATE)

}  // namespace imslam::nn
