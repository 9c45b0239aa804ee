#pragma once

#include <utility>

#include "slam/nn/kernels/packet_types.hpp"

namespace imslam::nn::kernels {
namespace {

/// Sums stay in registers: P pixels x Q packets of output channels, beside Q packets of weights and
/// one broadcast input.
constexpr int max_pixels(int packets) { return (kRegisters - 1 - packets) / packets; }

template <int P, int Q>
EIGEN_ALWAYS_INLINE void store_tile(const RowProduct& row,
                                    const Packet (&sum)[P][Q],
                                    float* output) {
  const Packet slope = pset1<Packet>(row.negative_slope);
  const bool activate = row.negative_slope != 1.0F;
#pragma GCC unroll 32
  for (int p = 0; p < P; ++p) {
#pragma GCC unroll 4
    for (int q = 0; q < Q; ++q) {
      Packet value = sum[p][q];
      if (activate) value = pselect(pcmp_lt(value, pzero(value)), pmul(value, slope), value);
      float* to = output + p * row.output_pitch + q * kLanes;
      store_lanes(to, value, q + 1 == Q ? row.last_lanes : kLanes);
    }
  }
}

/// sum += x[p pitch] w for one channel; x and w go on to the next channel.
template <int P, int Q>
EIGEN_ALWAYS_INLINE void multiply_channel(const float*& x,
                                          std::ptrdiff_t pitch,
                                          const float*& w,
                                          Packet (&sum)[P][Q]) {
  Packet weights[Q];
#pragma GCC unroll 4
  for (int q = 0; q < Q; ++q) weights[q] = load(w + q * kLanes);
#pragma GCC unroll 32
  for (int p = 0; p < P; ++p) {
    const Packet pixel = pset1<Packet>(x[p * pitch]);
#pragma GCC unroll 4
    for (int q = 0; q < Q; ++q) sum[p][q] = pmadd(pixel, weights[q], sum[p][q]);
  }
  ++x;
  w += Q * kLanes;
}

/// kPitch 0: the pitch is known at run time only.
template <int P, int Q, int kPitch>
void tile_product(const RowProduct& row, int first_pixel) {
  Packet sum[P][Q];
#pragma GCC unroll 32
  for (int p = 0; p < P; ++p) {
#pragma GCC unroll 4
    for (int q = 0; q < Q; ++q) sum[p][q] = load(row.bias + q * kLanes);
  }
  const std::ptrdiff_t pitch = kPitch > 0 ? kPitch : row.pixel_pitch;
  const float* w = row.weights;
  const float* plane = row.input + first_pixel * pitch;
  for (int b = 1; b <= row.blocks; ++b, plane += row.block_pitch) {
    const int channels = b < row.blocks ? kBlock : row.last_channels;
    for (int tap = 0; tap < row.tap_count; ++tap) {
      const float* x = plane + row.taps[tap];
      if (kPitch > 0 && kPitch < kBlock) {
        multiply_channel(x, pitch, w, sum);
      } else if (channels == kBlock) {
#pragma GCC unroll 4
        for (int c = 0; c < kBlock; ++c) multiply_channel(x, pitch, w, sum);
      } else {
#pragma GCC unroll 1
        for (int c = 0; c < channels; ++c) multiply_channel(x, pitch, w, sum);
      }
    }
  }
  store_tile<P, Q>(row, sum, row.output + first_pixel * row.output_pitch);
}

using TileProduct = void (*)(const RowProduct&, int);

template <int Q, int kPitch, int... P>
constexpr TileProduct choose_tile(int pixels, std::integer_sequence<int, P...>) {
  constexpr TileProduct kTiles[] = {tile_product<P + 1, Q, kPitch>...};
  return kTiles[pixels - 1];
}

/// Tiles of almost equal width: a narrow last one would not fill the multipliers' pipeline.
/// With a pitch known at run time only, the addresses of more pixels do not fit into registers.
constexpr int kMostAddresses = 14;

template <int Q, int kPitch>
void split_row(const RowProduct& row) {
  constexpr int kFitting = max_pixels(Q);
  constexpr int kMax = kPitch == 0 && kFitting > kMostAddresses ? kMostAddresses : kFitting;
  const int tiles = (row.pixels + kMax - 1) / kMax;
  for (int t = 0, first = 0; t < tiles; ++t) {
    const int pixels = (row.pixels - first + tiles - t - 1) / (tiles - t);
    choose_tile<Q, kPitch>(pixels, std::make_integer_sequence<int, kMax>())(row, first);
    first += pixels;
  }
}

template <int kPitch>
void row_product_of_pitch(const RowProduct& row) {
  switch (row.packets) {
    case 1:
      return split_row<1, kPitch>(row);
    case 2:
      return split_row<2, kPitch>(row);
    case 3:
      return split_row<3, kPitch>(row);
    default:
      return split_row<4, kPitch>(row);
  }
}

void row_product(const RowProduct& row) {
  switch (row.pixel_pitch) {
    case 1:
      return row_product_of_pitch<1>(row);
    case 4:
      return row_product_of_pitch<4>(row);
    case kBlock:
      return row_product_of_pitch<kBlock>(row);
    default:
      return row_product_of_pitch<0>(row);
  }
}

}  // namespace
}  // namespace imslam::nn::kernels
