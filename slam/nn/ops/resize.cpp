#include "slam/nn/ops/resize.hpp"

#include <algorithm>
#include <cmath>
#include <type_traits>

#include "slam/nn/kernels/instruction_set.hpp"

namespace imslam::nn {
namespace {

/// Which two neighbours along one axis make up a pixel of the output, and the share of the second.
struct Blend {
  Index first;
  Index second;
  double share;
};

enum class Method { kNearest, kBilinear, kAligned };

void fill_blends(Method method, Index from, Index to, Blend* blends) {
  const double ratio = static_cast<double>(from) / static_cast<double>(to);
  for (Index i = 0; i < to; ++i) {
    const double centre = (static_cast<double>(i) + 0.5) * ratio;
    if (method == Method::kNearest) {
      const Index pixel = std::min(static_cast<Index>(centre), from - 1);
      blends[i] = {pixel, pixel, 0.0};
      continue;
    }
    const double wanted = method == Method::kAligned ? 0.5 * static_cast<double>(i) : centre - 0.5;
    const double position = std::clamp(wanted, 0.0, static_cast<double>(from - 1));
    const auto first = static_cast<Index>(position);
    const Index second = std::min(first + 1, from - 1);
    blends[i] = {first, second, position - static_cast<double>(first)};
  }
}

struct Resizing {
  Index batch, in_height, in_width, channels, height, width;
  const Blend* rows;
  const Blend* columns;

  /// visit(at_x, weight, at_y) for each pixel of x that has a share in a pixel of y.
  template <typename S, typename Visit>
  void for_each_share(const Visit& visit) const {
    for (Index n = 0; n < batch; ++n) {
      for (Index i = 0; i < height; ++i) {
        for (Index j = 0; j < width; ++j) {
          const Blend& a = rows[i];
          const Blend& b = columns[j];
          const Index at_y = ((n * height + i) * width + j) * channels;
          const auto pixel = [&](Index row, Index column, double weight) {
            const Index at_x = ((n * in_height + row) * in_width + column) * channels;
            if (weight != 0.0) visit(at_x, S(weight), at_y);
          };
          pixel(a.first, b.first, (1 - a.share) * (1 - b.share));
          pixel(a.first, b.second, (1 - a.share) * b.share);
          pixel(a.second, b.first, a.share * (1 - b.share));
          pixel(a.second, b.second, a.share * b.share);
        }
      }
    }
  }
};

template <typename S>
Resizing prepare(Tape<S>& tape, const Shape& x, Index height, Index width, Method method) {
  Blend* const rows = tape.template keep<Blend>(height);
  Blend* const columns = tape.template keep<Blend>(width);
  fill_blends(method, x[1], height, rows);
  fill_blends(method, x[2], width, columns);
  return {x[0], x[1], x[2], x[3], height, width, rows, columns};
}

/// Y += resized X
template <typename S>
void spread(const Resizing& r, const S* X, S* Y) {
  r.template for_each_share<S>([&](Index at_x, S weight, Index at_y) {
    for (Index c = 0; c < r.channels; ++c) Y[at_y + c] += weight * X[at_x + c];
  });
}

/// dX += what each pixel of X gave to dY
template <typename S>
void gather(const Resizing& r, const S* dY, S* dX) {
  r.template for_each_share<S>([&](Index at_x, S weight, Index at_y) {
    for (Index c = 0; c < r.channels; ++c) dX[at_x + c] += weight * dY[at_y + c];
  });
}

template <typename S>
Var resize(Tape<S>& tape, Var x, Index height, Index width, Method method) {
  const Shape shape = tape.shape(x);
  expects_shape(shape.rank() == 4 && height >= 1 && width >= 1 && shape[1] >= 1 && shape[2] >= 1,
                "resize: x [N,H,W,C] to at least one pixel", shape);
  const Resizing r = prepare(tape, shape, height, width, method);
  const Var y = tape.make({shape[0], height, width, shape[3]});
  tape.array(y) = S(0);
  spread(r, tape.data(x), tape.data(y));
  return tape.record(y, {x},
                     [=](Tape<S>& t) { gather(r, t.gradient_data(y), t.gradient_data(x)); });
}

void add_upsampled_rows(const Shape& shape, const float* fine, const float* x, float* y) {
  const Index height = shape[1];
  const Index pitch = shape[2] * shape[3];
  const Index pitch_of_x = (shape[2] + 1) / 2 * shape[3];
  const Index last = (height - 1) / 2;
  for (Index row = 0; row < shape[0] * height; ++row) {
    const Index i = row % height;
    const float* const image = x + row / height * (last + 1) * pitch_of_x;
    const float* const above = image + i / 2 * pitch_of_x;
    const bool between = i % 2 == 1 && i / 2 < last;
    kernels::selected_kernels().upsample_add(
        {above, between ? above + pitch_of_x : above, fine + row * pitch, y + row * pitch,
         static_cast<int>(shape[2]), static_cast<int>(shape[3])});
  }
}

}  // namespace

template <typename S>
Var resize_nearest(Tape<S>& tape, Var x, Index height, Index width) {
  return resize(tape, x, height, width, Method::kNearest);
}

template <typename S>
Var resize_bilinear(Tape<S>& tape, Var x, Index height, Index width) {
  return resize(tape, x, height, width, Method::kBilinear);
}

template <typename S>
Var upsample2_nearest(Tape<S>& tape, Var x) {
  return resize_nearest(tape, x, 2 * tape.shape(x)[1], 2 * tape.shape(x)[2]);
}

template <typename S>
Var upsample2_bilinear(Tape<S>& tape, Var x) {
  return resize_bilinear(tape, x, 2 * tape.shape(x)[1], 2 * tape.shape(x)[2]);
}

template <typename S>
Var upsample2_aligned(Tape<S>& tape, Var x, Index height, Index width) {
  const Shape shape = tape.shape(x);
  expects_shapes(shape.rank() == 4 && shape[1] == (height + 1) / 2 && shape[2] == (width + 1) / 2,
                 "upsample2_aligned: x is half as large, rounded up", shape, {height, width});
  return resize(tape, x, height, width, Method::kAligned);
}

template <typename S>
Var add_upsampled2(Tape<S>& tape, Var fine, Var x) {
  const Shape shape = tape.shape(fine);
  expects_shapes(
      shape.rank() == 4 && shape[1] >= 1 && shape[2] >= 1 &&
          tape.shape(x) == Shape{shape[0], (shape[1] + 1) / 2, (shape[2] + 1) / 2, shape[3]},
      "add_upsampled2: x is half as large as fine, rounded up", tape.shape(x), shape);
  const Resizing r = prepare(tape, tape.shape(x), shape[1], shape[2], Method::kAligned);
  const Var y = tape.make(shape);
  if constexpr (std::is_same_v<S, float>) {
    add_upsampled_rows(shape, tape.data(fine), tape.data(x), tape.data(y));
  } else {
    tape.array(y) = tape.array(fine);
    spread(r, tape.data(x), tape.data(y));
  }
  return tape.record(y, {fine, x}, [=](Tape<S>& t) {
    if (t.wants_gradient(x)) gather(r, t.gradient_data(y), t.gradient_data(x));
    t.pass_on(y, fine);
  });
}

#define INSTANTIATE(S)                                         \
  template Var resize_nearest(Tape<S>&, Var, Index, Index);    \
  template Var resize_bilinear(Tape<S>&, Var, Index, Index);   \
  template Var upsample2_nearest(Tape<S>&, Var);               \
  template Var upsample2_bilinear(Tape<S>&, Var);              \
  template Var upsample2_aligned(Tape<S>&, Var, Index, Index); \
  template Var add_upsampled2(Tape<S>&, Var, Var);
IMSLAM_NN_FOR_EACH_SCALAR(INSTANTIATE)

}  // namespace imslam::nn
