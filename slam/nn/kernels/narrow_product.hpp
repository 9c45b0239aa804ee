#pragma once

#include <utility>

#include "slam/nn/kernels/packet_types.hpp"

namespace imslam::nn::kernels {
namespace {

/// For fewer output channels than a packet has lanes: packets run along the input channels, and a
/// tile holds P pixels x O outputs whose lanes are added at the end.
constexpr int kNarrowPixels = kRegisters == 32 ? 6 : 3;

template <int P, int O>
void narrow_tile(const RowProduct& row, const float* input, float* output) {
  Packet sum[P][O];
#pragma GCC unroll 8
  for (int p = 0; p < P; ++p) {
#pragma GCC unroll 4
    for (int o = 0; o < O; ++o) sum[p][o] = pset1<Packet>(0.0F);
  }
  const float* w = row.weights;
  for (int b = 0; b < row.blocks; ++b, input += row.block_pitch) {
    for (int tap = 0; tap < row.tap_count; ++tap, w += O * kBlock) {
      const float* x = input + row.taps[tap];
#pragma GCC unroll 4
      for (int c = 0; c < kBlock; c += kLanes) {
        Packet weights[O];
#pragma GCC unroll 4
        for (int o = 0; o < O; ++o) weights[o] = load(w + o * kBlock + c);
#pragma GCC unroll 8
        for (int p = 0; p < P; ++p) {
          const Packet pixel = load(x + p * std::ptrdiff_t{row.pixel_pitch} + c);
#pragma GCC unroll 4
          for (int o = 0; o < O; ++o) sum[p][o] = pmadd(pixel, weights[o], sum[p][o]);
        }
      }
    }
  }
#pragma GCC unroll 8
  for (int p = 0; p < P; ++p) {
#pragma GCC unroll 4
    for (int o = 0; o < O; ++o) {
      const float value = predux(sum[p][o]) + row.bias[o];
      output[p * row.output_pitch + o] = value < 0 ? value * row.negative_slope : value;
    }
  }
}

using NarrowTile = void (*)(const RowProduct&, const float*, float*);

template <int O, int... P>
constexpr NarrowTile choose_narrow(int pixels, std::integer_sequence<int, P...>) {
  constexpr NarrowTile kTiles[] = {narrow_tile<P + 1, O>...};
  return kTiles[pixels - 1];
}

template <int O>
void split_narrow_row(const RowProduct& row) {
  for (int first = 0; first < row.pixels; first += kNarrowPixels) {
    const int left = row.pixels - first;
    const int pixels = left < kNarrowPixels ? left : kNarrowPixels;
    choose_narrow<O>(pixels, std::make_integer_sequence<int, kNarrowPixels>())(
        row, row.input + std::ptrdiff_t{first} * row.pixel_pitch,
        row.output + first * row.output_pitch);
  }
}

/// `packets` counts outputs; weights [blocks, taps, outputs, kBlock], zero where no channel is.
void narrow_product(const RowProduct& row) {
  switch (row.packets) {
    case 1:
      return split_narrow_row<1>(row);
    case 2:
      return split_narrow_row<2>(row);
    case 3:
      return split_narrow_row<3>(row);
    default:
      return split_narrow_row<4>(row);
  }
}

}  // namespace
}  // namespace imslam::nn::kernels
