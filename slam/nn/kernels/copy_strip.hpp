#pragma once

#include "slam/nn/kernels/packet_types.hpp"

namespace imslam::nn::kernels {
namespace {

void copy_channels(const float* from, int channels, int pitch, float* to) {
  if (channels == kBlock) {
#pragma GCC unroll 4
    for (int c = 0; c < kBlock; c += kLanes) pstoreu(to + c, load(from + c));
    return;
  }
  for (int c = 0; c < channels; ++c) to[c] = from[c];
  for (int c = channels; c < pitch; ++c) to[c] = 0;
}

/// One row of one block; `from` is null where the row lies outside of the image.
void copy_row(const StripCopy& copy, const float* from, int channels, float* to) {
  const int pitch = copy.pixel_pitch;
  for (int remainder = 0; remainder < copy.stride; ++remainder, to += copy.lane_columns * pitch) {
    float* pixel = to;
    for (int u = remainder; u < copy.columns; u += copy.stride, pixel += pitch) {
      const int x = copy.first_column + u;
      const bool inside = from != nullptr && x >= 0 && x < copy.width;
      if (inside) copy_channels(from + std::ptrdiff_t{x} * copy.channels, channels, pitch, pixel);
      if (!inside) copy_channels(nullptr, 0, pitch, pixel);
    }
  }
}

template <int Q>
void copy_gradient_group(const GradientCopy& copy) {
  Packet sum[Q];
  for (int q = 0; q < Q; ++q) sum[q] = load(copy.sum + q * kLanes);
  const float* from = copy.dy;
  float* to = copy.packed;
  for (int p = 0; p < copy.pixels; ++p, from += copy.pixel_pitch, to += Q * kLanes) {
#pragma GCC unroll 4
    for (int q = 0; q < Q; ++q) {
      const Packet value = load_lanes(from + q * kLanes, q + 1 == Q ? copy.last_lanes : kLanes);
      sum[q] = padd(sum[q], value);
      pstoreu(to + q * kLanes, value);
    }
  }
  for (int q = 0; q < Q; ++q) pstoreu(copy.sum + q * kLanes, sum[q]);
}

void copy_gradient(const GradientCopy& copy) {
  switch (copy.packets) {
    case 1:
      return copy_gradient_group<1>(copy);
    case 2:
      return copy_gradient_group<2>(copy);
    case 3:
      return copy_gradient_group<3>(copy);
    default:
      return copy_gradient_group<4>(copy);
  }
}

void copy_strip(const StripCopy& copy) {
  for (int r = 0; r < copy.rows; ++r) {
    const int y = copy.first_row + r;
    const bool inside = y >= 0 && y < copy.height;
    const float* row =
        inside ? copy.image + std::ptrdiff_t{y} * copy.width * copy.channels : nullptr;
    for (int c = 0, b = 0; c < copy.channels; c += kBlock, ++b) {
      const int channels = copy.channels - c < kBlock ? copy.channels - c : kBlock;
      float* to = copy.packed + b * copy.block_pitch + r * copy.row_pitch;
      copy_row(copy, inside ? row + c : nullptr, channels, to);
    }
  }
}

}  // namespace
}  // namespace imslam::nn::kernels
