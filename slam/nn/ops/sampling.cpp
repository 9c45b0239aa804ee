#include "slam/nn/ops/sampling.hpp"

#include <array>
#include <cmath>

#include "slam/nn/ops/arithmetic.hpp"
#include "slam/nn/ops/layout.hpp"

namespace imslam::nn {
namespace {

constexpr double kFarAway = 1e9;  // beyond it a coordinate does not fit into an int

/// One coordinate: the pixel at or before it and the part after that pixel.
template <typename S>
struct Position {
  Index before = 0;
  S part = S(0);
  bool moves = true;  ///< false: clamped, the coordinate has no influence
};

template <typename S>
Position<S> position_of(S x, Index size, Border border) {
  Position<S> p;
  if (border == Border::kClamp) {
    const S last = S(static_cast<double>(size - 1));
    p.moves = x > S(0) && x < last;
    if (!(x > S(0))) x = S(0);
    if (x > last) x = last;
  }
  const auto floor = std::floor(static_cast<double>(value_of(x)));
  p.before = static_cast<Index>(floor);
  p.part = x - S(floor);
  return p;
}

/// Where a point reads: offsets of four pixels (-1: outside, zero) and their weights.
template <typename S>
struct Corners {
  std::array<Index, 4> offsets{-1, -1, -1, -1};  ///< (x, y), (x+1, y), (x, y+1), (x+1, y+1)
  std::array<S, 4> weights{};
  Position<S> x;
  Position<S> y;
};

struct Image {
  Index height, width, channels;

  template <typename S>
  Corners<S> corners(Index sample, S x, S y, Border border) const {
    Corners<S> c;
    const auto reachable = [](S v) {
      return std::abs(static_cast<double>(value_of(v))) < kFarAway;
    };
    if (!reachable(x) || !reachable(y)) {
      c.x.moves = c.y.moves = false;
      return c;
    }
    c.x = position_of(x, width, border);
    c.y = position_of(y, height, border);
    const S u = c.x.part;
    const S v = c.y.part;
    c.weights = {(S(1) - u) * (S(1) - v), u * (S(1) - v), (S(1) - u) * v, u * v};
    for (std::size_t k = 0; k < 4; ++k) {
      const Index column = c.x.before + static_cast<Index>(k % 2);
      const Index row = c.y.before + static_cast<Index>(k / 2);
      if (column < 0 || column >= width || row < 0 || row >= height) continue;
      c.offsets[k] = ((sample * height + row) * width + column) * channels;
    }
    return c;
  }
};

template <typename S>
void sample_forward(
    const Image& image, Index samples, Index count, Border border, const S* I, const S* P, S* Y) {
  for (Index i = 0; i < samples * count; ++i) {
    const Corners<S> corners = image.corners(i / count, P[2 * i], P[2 * i + 1], border);
    S* const y = Y + i * image.channels;
    std::fill_n(y, image.channels, S(0));
    for (std::size_t k = 0; k < 4; ++k) {
      if (corners.offsets[k] < 0) continue;
      const S* const pixel = I + corners.offsets[k];
      for (Index c = 0; c < image.channels; ++c) y[c] += corners.weights[k] * pixel[c];
    }
  }
}

/// <dy, I> of each corner, 0 outside: what moving the point needs.
template <typename S>
std::array<S, 4> corner_products(const Image& image,
                                 const Corners<S>& corners,
                                 const S* I,
                                 const S* dy) {
  std::array<S, 4> products{S(0), S(0), S(0), S(0)};
  for (std::size_t k = 0; k < 4; ++k) {
    if (corners.offsets[k] < 0) continue;
    for (Index c = 0; c < image.channels; ++c) products[k] += dy[c] * I[corners.offsets[k] + c];
  }
  return products;
}

template <typename S>
void sample_backward(Tape<S>& t, const Image& image, Border border, Var of, Var points, Var y) {
  const Shape shape = t.shape(points);
  const S* const P = t.data(points);
  const S* const I = t.data(of);
  S* const dI = t.wants_gradient(of) ? t.gradient_data(of) : nullptr;
  S* const dP = t.wants_gradient(points) ? t.gradient_data(points) : nullptr;
  for (Index i = 0; i < shape.rows(); ++i) {
    const Corners<S> corners = image.corners(i / shape[1], P[2 * i], P[2 * i + 1], border);
    const S* const dy = t.gradient_data(y) + i * image.channels;
    for (std::size_t k = 0; dI != nullptr && k < 4; ++k) {
      if (corners.offsets[k] < 0) continue;
      S* const pixel = dI + corners.offsets[k];
      for (Index c = 0; c < image.channels; ++c) pixel[c] += corners.weights[k] * dy[c];
    }
    if (dP == nullptr) continue;
    const std::array<S, 4> d = corner_products(image, corners, I, dy);
    const S u = corners.x.part;
    const S v = corners.y.part;
    if (corners.x.moves) dP[2 * i] += (S(1) - v) * (d[1] - d[0]) + v * (d[3] - d[2]);
    if (corners.y.moves) dP[2 * i + 1] += (S(1) - u) * (d[2] - d[0]) + u * (d[3] - d[1]);
  }
}

}  // namespace

template <typename S>
Var bilinear_sample(Tape<S>& tape, Var image, Var points, Border border) {
  const Shape of_image = tape.shape(image);
  const Shape of_points = tape.shape(points);
  expects_shapes(of_image.rank() == 4 && of_points.rank() == 3 && of_points[2] == 2 &&
                     of_image[0] == of_points[0] && of_image[1] > 0 && of_image[2] > 0,
                 "bilinear_sample: image [N,H,W,C] and points [N,P,2]", of_image, of_points);
  const Image view{of_image[1], of_image[2], of_image[3]};
  const Var y = tape.make({of_points[0], of_points[1], of_image[3]});
  sample_forward(view, of_points[0], of_points[1], border, tape.data(image), tape.data(points),
                 tape.data(y));
  return tape.record(y, {image, points},
                     [=](Tape<S>& t) { sample_backward(t, view, border, image, points, y); });
}

template <typename S>
Var warp(Tape<S>& tape, Var image, Var flow, Border border) {
  const Shape shape = tape.shape(flow);
  expects_shape(shape.rank() == 4 && shape[3] == 2, "warp: flow [N,h,w,2]", shape);
  const Index height = shape[1];
  const Index width = shape[2];
  const Var grid = tape.make({height, width, 2});
  for (Index i = 0; i < height; ++i) {
    for (Index j = 0; j < width; ++j) {
      tape.data(grid)[(i * width + j) * 2] = S(static_cast<double>(j));
      tape.data(grid)[(i * width + j) * 2 + 1] = S(static_cast<double>(i));
    }
  }
  const Var points = reshape(tape, add(tape, flow, grid), {shape[0], height * width, 2});
  const Var y = bilinear_sample(tape, image, points, border);
  return reshape(tape, y, {shape[0], height, width, tape.shape(image)[3]});
}

#define INSTANTIATE(S)                                      \
  template Var bilinear_sample(Tape<S>&, Var, Var, Border); \
  template Var warp(Tape<S>&, Var, Var, Border);
IMSLAM_NN_FOR_EACH_SCALAR(INSTANTIATE)

}  // namespace imslam::nn
