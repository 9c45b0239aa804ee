#pragma once

#include "slam/nn/kernels/packet_types.hpp"

namespace imslam::nn::kernels {
namespace {

/// fine + sum of Columns x Rows coarse pixels, all with the same share.
template <int kPixels>
EIGEN_ALWAYS_INLINE void blend_pixel(const float* const (&pixels)[kPixels],
                                     const float* fine,
                                     int channels,
                                     float* y) {
  constexpr float kShare = 1.0F / kPixels;
  const Packet share = pset1<Packet>(kShare);
  int c = 0;
  for (; c + kLanes <= channels; c += kLanes) {
    Packet sum = pmul(load(pixels[0] + c), share);
#pragma GCC unroll 4
    for (int k = 1; k < kPixels; ++k) sum = padd(sum, pmul(load(pixels[k] + c), share));
    pstoreu(y + c, padd(load(fine + c), sum));
  }
  for (; c < channels; ++c) {
    float sum = pixels[0][c] * kShare;
    for (int k = 1; k < kPixels; ++k) sum += pixels[k][c] * kShare;
    y[c] = fine[c] + sum;
  }
}

void upsample_add(const UpsampleRow& row) {
  const std::ptrdiff_t channels = row.channels;
  const int last = (row.width - 1) / 2;
  for (int j = 0; j < row.width; ++j) {
    const std::ptrdiff_t here = j / 2 * channels;
    const std::ptrdiff_t next = (j / 2 < last ? j / 2 + 1 : last) * channels;
    const float* const fine = row.fine + j * channels;
    float* const y = row.y + j * channels;
    const bool between = j % 2 == 1;
    if (row.above == row.below && !between) {
      blend_pixel<1>({row.above + here}, fine, row.channels, y);
    } else if (row.above == row.below) {
      blend_pixel<2>({row.above + here, row.above + next}, fine, row.channels, y);
    } else if (!between) {
      blend_pixel<2>({row.above + here, row.below + here}, fine, row.channels, y);
    } else {
      blend_pixel<4>({row.above + here, row.above + next, row.below + here, row.below + next}, fine,
                     row.channels, y);
    }
  }
}

/// Not max(): what is not a number must stay none.
void add_relu(const float* a, const float* b, std::ptrdiff_t count, float* y) {
  const Packet zero = pset1<Packet>(0.0F);
  std::ptrdiff_t i = 0;
  for (; i + kLanes <= count; i += kLanes) {
    const Packet sum = padd(load(a + i), load(b + i));
    pstoreu(y + i, pselect(pcmp_lt(sum, zero), zero, sum));
  }
  for (; i < count; ++i) {
    const float sum = a[i] + b[i];
    y[i] = sum < 0.0F ? 0.0F : sum;
  }
}

EIGEN_ALWAYS_INLINE float dot(const float* a, const float* b, int count) {
  int c = 0;
  float rest = 0.0F;
  Packet sum = pset1<Packet>(0.0F);
  for (; c + kLanes <= count; c += kLanes) sum = pmadd(load(a + c), load(b + c), sum);
  for (; c < count; ++c) rest += a[c] * b[c];
  return predux(sum) + rest;
}

void dot_products(
    const float* query, const float* pixels, std::ptrdiff_t count, int channels, float* y) {
  for (std::ptrdiff_t i = 0; i < count; ++i) y[i] = dot(query, pixels + i * channels, channels);
}

void unit_rows(const float* x,
               std::ptrdiff_t rows,
               int channels,
               float smallest_square,
               float* inverse,
               float* y) {
  for (std::ptrdiff_t r = 0; r < rows; ++r, x += channels, y += channels) {
    inverse[r] = 1.0F / __builtin_sqrtf(dot(x, x, channels) + smallest_square);
    const Packet factor = pset1<Packet>(inverse[r]);
    int c = 0;
    for (; c + kLanes <= channels; c += kLanes) pstoreu(y + c, pmul(factor, load(x + c)));
    for (; c < channels; ++c) y[c] = inverse[r] * x[c];
  }
}

}  // namespace
}  // namespace imslam::nn::kernels
