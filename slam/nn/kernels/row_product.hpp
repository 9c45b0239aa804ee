#pragma once

#include <utility>

#include "slam/nn/kernels/packet_types.hpp"

namespace imslam::nn::kernels {
namespace {

/// Sums stay in registers: P pixels x Q packets of output channels, beside Q packets of weights and
/// one broadcast input.
constexpr int max_pixels(int packets) { return (kRegisters - 1 - packets) / packets; }

template <bool kActivate, bool kWhole, int P, int Q>
EIGEN_ALWAYS_INLINE void store_sums(const RowProduct& row,
                                    const Packet (&sum)[P][Q],
                                    float* output) {
  const Packet slope = pset1<Packet>(row.negative_slope);
  const std::ptrdiff_t pitch = row.output_pitch;
  const int last_lanes = kWhole ? kLanes : row.last_lanes;
#pragma GCC unroll 32
  for (int p = 0; p < P; ++p) {
#pragma GCC unroll 4
    for (int q = 0; q < Q; ++q) {
      Packet value = sum[p][q];
      if (kActivate) value = pselect(pcmp_lt(value, pzero(value)), pmul(value, slope), value);
      store_lanes(output + p * pitch + q * kLanes, value, q + 1 == Q ? last_lanes : kLanes);
    }
  }
}

/// What is the same for all of a tile is asked once: where there are few taps, the stores would
/// take as long as the products.
template <int P, int Q>
EIGEN_ALWAYS_INLINE void store_tile(const RowProduct& row,
                                    const Packet (&sum)[P][Q],
                                    float* output) {
  const bool activate = row.negative_slope != 1.0F;
  if (row.last_lanes < kLanes) return store_sums<true, false>(row, sum, output);
  if (activate) return store_sums<true, true>(row, sum, output);
  store_sums<false, true>(row, sum, output);
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

template <int P, int Q>
EIGEN_ALWAYS_INLINE void prefetch_output(const RowProduct& row, const float* output) {
#pragma GCC unroll 32
  for (int p = 0; p < P; ++p) {
#pragma GCC unroll 4
    for (int q = 0; q < Q; ++q) __builtin_prefetch(output + p * row.output_pitch + q * kLanes, 1);
  }
}

/// Asks for one block of the pixels of the next tile, as one of its taps reads them: the last, in
/// the newest row, and the middle one, whose row is new, too, where the stride is 2. Without it
/// every tile would begin by waiting for the memory.
template <int P, int kPitch>
EIGEN_ALWAYS_INLINE void prefetch_tile(const float* x, std::ptrdiff_t pitch) {
  constexpr bool kDense = kPitch > 0 && kPitch < kBlock;
#pragma GCC unroll 32
  for (int p = 0; p < (kDense ? (P * kPitch + kBlock - 1) / kBlock : P); ++p) {
    __builtin_prefetch(x + p * (kDense ? kBlock : pitch));
  }
}

/// kPitch 0: the pitch is known at run time only. `next` is where the next tile's pixels begin.
template <int P, int Q, int kPitch>
void tile_product(const RowProduct& row, int first_pixel, const float* next) {
  Packet sum[P][Q];
#pragma GCC unroll 32
  for (int p = 0; p < P; ++p) {
#pragma GCC unroll 4
    for (int q = 0; q < Q; ++q) sum[p][q] = load(row.bias + q * kLanes);
  }
  const std::ptrdiff_t pitch = kPitch > 0 ? kPitch : row.pixel_pitch;
  float* const output = row.output + first_pixel * row.output_pitch;
  if (row.tap_count > 1) prefetch_output<P, Q>(row, output);
  const float* w = row.weights;
  const float* plane = row.input + first_pixel * pitch;
  const std::ptrdiff_t newest = row.tap_count > 0 ? row.taps[row.tap_count - 1] : 0;
  const std::ptrdiff_t middle = row.tap_count > 1 ? row.taps[row.tap_count / 2] : newest;
  for (int b = 1; b <= row.blocks; ++b, plane += row.block_pitch, next += row.block_pitch) {
    prefetch_tile<P, kPitch>(next + newest, pitch);
    if (middle != newest) prefetch_tile<P, kPitch>(next + middle, pitch);
    const int channels = b < row.blocks ? kBlock : row.last_channels;
    for (int tap = 0; tap < row.tap_count; ++tap) {
      const float* x = plane + row.taps[tap];
      if (kPitch > 0 && kPitch < kBlock) {
        multiply_channel(x, pitch, w, sum);
      } else if (channels == kBlock) {
#pragma GCC unroll 1
        for (int c = 0; c < kBlock; ++c) multiply_channel(x, pitch, w, sum);
      } else {
#pragma GCC unroll 1
        for (int c = 0; c < channels; ++c) multiply_channel(x, pitch, w, sum);
      }
    }
  }
  store_tile<P, Q>(row, sum, output);
}

using TileProduct = void (*)(const RowProduct&, int, const float*);

/// Tiles of 1 to 8 pixels, then of even numbers only: half as many functions to compile.
constexpr int kSmallTiles = 8;
constexpr int tile_index(int pixels) {
  return pixels <= kSmallTiles ? pixels - 1 : kSmallTiles - 1 + (pixels - kSmallTiles) / 2;
}
constexpr int tile_pixels(int index) {
  return index < kSmallTiles ? index + 1 : kSmallTiles + 2 * (index - kSmallTiles + 1);
}

template <int Q, int kPitch, int... Index>
constexpr TileProduct choose_tile(int pixels, std::integer_sequence<int, Index...>) {
  constexpr TileProduct kTiles[] = {tile_product<tile_pixels(Index), Q, kPitch>...};
  return kTiles[tile_index(pixels)];
}

/// With a pitch known at run time only, the addresses of more pixels do not fit into registers.
constexpr int kMostAddresses = 14;

/// Tiles of almost equal width: a narrow last one would not fill the multipliers' pipeline.
template <int Q, int kPitch>
void split_row(const RowProduct& row) {
  constexpr int kFitting = max_pixels(Q);
  constexpr int kMax = kPitch == 0 && kFitting > kMostAddresses ? kMostAddresses : kFitting;
  constexpr int kWidest = kMax > kSmallTiles ? kMax / 2 * 2 : kMax;
  for (int first = 0; first < row.pixels;) {
    const int left = row.pixels - first;
    const int tiles = (left + kWidest - 1) / kWidest;
    int pixels = (left + tiles - 1) / tiles;
    if (pixels > kSmallTiles && pixels % 2 == 1) pixels += pixels < left ? 1 : -(kSmallTiles - 1);
    const bool last = first + pixels == row.pixels;
    const float* next =
        last ? row.next : row.input + std::ptrdiff_t{first + pixels} * row.pixel_pitch;
    constexpr auto kIndices = std::make_integer_sequence<int, tile_index(kWidest) + 1>();
    choose_tile<Q, kPitch>(pixels, kIndices)(row, first, next);
    first += pixels;
  }
}

/// Pitches are known to the compiler where they can be: the addresses of a tile are then constants.
void row_of_one_packet(const RowProduct& row) {
  switch (row.pixel_pitch) {
    case kBlock:
      return split_row<1, kBlock>(row);
    case 2 * kBlock:
      return split_row<1, 2 * kBlock>(row);
    default:
      return split_row<1, 0>(row);
  }
}

void row_of_two_packets(const RowProduct& row) {
  switch (row.pixel_pitch) {
    case kBlock:
      return split_row<2, kBlock>(row);
    case 2 * kBlock:
      return split_row<2, 2 * kBlock>(row);
    case 4 * kBlock:
      return split_row<2, 4 * kBlock>(row);
    default:
      return split_row<2, 0>(row);
  }
}

/// Few channels, each a tap of its own.
void few_channels_one_packet(const RowProduct& row) {
  switch (row.pixel_pitch) {
    case 1:
      return split_row<1, 1>(row);
    case 3:
      return split_row<1, 3>(row);
    case 4:
      return split_row<1, 4>(row);
    case 6:
      return split_row<1, 6>(row);
    default:
      return split_row<1, 0>(row);
  }
}

void few_channels_two_packets(const RowProduct& row) {
  switch (row.pixel_pitch) {
    case 1:
      return split_row<2, 1>(row);
    case 4:
      return split_row<2, 4>(row);
    default:
      return split_row<2, 0>(row);
  }
}

void row_product(const RowProduct& row) {
  const bool few_channels = row.blocks == 1 && row.last_channels == 1;
  if (few_channels && row.packets == 1) return few_channels_one_packet(row);
  if (few_channels) return few_channels_two_packets(row);
  if (row.packets == 1) return row_of_one_packet(row);
  row_of_two_packets(row);
}

}  // namespace
}  // namespace imslam::nn::kernels
