#pragma once

#include "slam/nn/kernels/packet_types.hpp"

namespace imslam::nn::kernels {
namespace {

EIGEN_ALWAYS_INLINE void copy_block(const float* from, float* to) {
#pragma GCC unroll 4
  for (int c = 0; c < kBlock; c += kLanes) pstoreu(to + c, load(from + c));
}

/// A block that is not full, with zeros behind its channels.
EIGEN_ALWAYS_INLINE void copy_part(const float* from, int channels, float* to) {
#pragma GCC unroll 4
  for (int c = 0; c < kBlock; c += kLanes) {
    const int lanes = channels - c < kLanes ? channels - c : kLanes;
    pstoreu(to + c, lanes > 0 ? load_lanes(from + c, lanes) : pset1<Packet>(0.0F));
  }
}

/// Few channels, not in blocks.
void copy_small_pixels(const StripCopy& copy, const float* from, int count, float* to) {
  const std::ptrdiff_t step = std::ptrdiff_t{copy.stride} * copy.channels;
  if (copy.pixel_pitch == 1 && step == 1) {
    __builtin_memcpy(to, from, static_cast<std::size_t>(count) * sizeof(float));
    return;
  }
  if (copy.pixel_pitch == 1) {
    for (int i = 0; i < count; ++i) to[i] = from[i * step];
    return;
  }
  // Four floats at once, some of the next pixel, which the last one of the image does not have.
  for (int i = 0; i + 1 < count; ++i, from += step, to += copy.pixel_pitch) {
    pstoreu(to, ploadu<Packet4>(from));
  }
  for (int c = 0; c < copy.channels; ++c) to[c] = from[c];
}

/// Pixels u = remainder, remainder + stride, ... of one row; `from` is the row's first pixel, null
/// outside of the image.
void copy_lane(const StripCopy& copy, const float* from, int remainder, int channels, float* to) {
  const int pitch = copy.pixel_pitch;
  const int pixels = (copy.columns - remainder + copy.stride - 1) / copy.stride;
  const int first = copy.first_column + remainder;  // column of the image
  const auto clamp = [pixels](int i) { return i < 0 ? 0 : (i > pixels ? pixels : i); };
  const auto cells = [&copy](int columns) {
    return columns <= 0 ? 0 : (columns + copy.stride - 1) / copy.stride;
  };
  const int begin = from == nullptr ? pixels : clamp(cells(-first));
  const int end = from == nullptr ? pixels : clamp(cells(copy.width - first));
  for (int i = 0; i < begin * pitch; ++i) to[i] = 0;
  if (begin < end) {
    from += (std::ptrdiff_t{first} + std::ptrdiff_t{begin} * copy.stride) * copy.channels;
    const std::ptrdiff_t step = std::ptrdiff_t{copy.stride} * copy.channels;
    float* pixel = to + begin * pitch;
    if (pitch < kBlock) {
      copy_small_pixels(copy, from, end - begin, pixel);
    } else if (channels == kBlock) {
      for (int i = begin; i < end; ++i, from += step, pixel += kBlock) copy_block(from, pixel);
    } else {
      for (int i = begin; i < end; ++i, from += step, pixel += kBlock) {
        copy_part(from, channels, pixel);
      }
    }
  }
  for (int i = end * pitch; i < pixels * pitch; ++i) to[i] = 0;
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
  if (copy.packets == 1) return copy_gradient_group<1>(copy);
  copy_gradient_group<kMostPackets>(copy);
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
      for (int remainder = 0; remainder < copy.stride; ++remainder) {
        copy_lane(copy, inside ? row + c : nullptr, remainder, channels, to);
        to += std::ptrdiff_t{copy.lane_columns} * copy.pixel_pitch;
      }
    }
  }
}

}  // namespace
}  // namespace imslam::nn::kernels
