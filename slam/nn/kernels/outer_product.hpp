#pragma once

#include <utility>

#include "slam/nn/kernels/packet_types.hpp"

namespace imslam::nn::kernels {
namespace {

/// Rows of the tile of sums, R channels x Q packets.
constexpr int max_channels(int packets, bool few_channels) {
  if (kRegisters == 32) return few_channels ? 9 : 16 / packets;
  return few_channels ? 10 / packets : (packets == 1 ? 8 : 6);
}

/// kPitch < kBlock: each row of the tile has its own tap; else they are neighbours.
template <int R, int Q, int kPitch>
void outer_tile(const OuterProduct& product, int first_channel) {
  constexpr bool kFew = kPitch < kBlock;
  float* const to = product.sum + first_channel * Q * kLanes;
  Packet sum[R][Q];
  const float* taps[R];
#pragma GCC unroll 16
  for (int r = 0; r < R; ++r) {
    taps[r] = product.x + (kFew ? product.taps[first_channel + r] : first_channel + r);
#pragma GCC unroll 4
    for (int q = 0; q < Q; ++q) sum[r][q] = load(to + (r * Q + q) * kLanes);
  }
  const float* dy = product.dy;
  const float* hint = first_channel == 0 ? product.hint : product.hint_end;
  for (int y = 0; y < product.rows; ++y) {
    std::ptrdiff_t x = y * product.x_row_pitch;
    for (int p = 0; p < product.pixels; ++p, x += kPitch, dy += Q * kLanes) {
      __builtin_prefetch(hint);
      hint = hint < product.hint_end ? hint + kBlock : hint;
      Packet gradient[Q];
#pragma GCC unroll 4
      for (int q = 0; q < Q; ++q) gradient[q] = load(dy + q * kLanes);
#pragma GCC unroll 16
      for (int r = 0; r < R; ++r) {
        const Packet value = pset1<Packet>(kFew ? taps[r][x] : taps[0][x + r]);
#pragma GCC unroll 4
        for (int q = 0; q < Q; ++q) sum[r][q] = pmadd(value, gradient[q], sum[r][q]);
      }
    }
  }
#pragma GCC unroll 16
  for (int r = 0; r < R; ++r) {
#pragma GCC unroll 4
    for (int q = 0; q < Q; ++q) pstoreu(to + (r * Q + q) * kLanes, sum[r][q]);
  }
}

using OuterTile = void (*)(const OuterProduct&, int);

template <int Q, int kPitch, int... R>
constexpr OuterTile choose_outer(int channels, std::integer_sequence<int, R...>) {
  constexpr OuterTile kTiles[] = {outer_tile<R + 1, Q, kPitch>...};
  return kTiles[channels - 1];
}

template <int Q, int kPitch>
void split_channels(const OuterProduct& product) {
  constexpr int kMax = max_channels(Q, kPitch < kBlock);
  const int tiles = (product.channels + kMax - 1) / kMax;
  for (int t = 0, first = 0; t < tiles; ++t) {
    const int channels = (product.channels - first + tiles - t - 1) / (tiles - t);
    choose_outer<Q, kPitch>(channels, std::make_integer_sequence<int, kMax>())(product, first);
    first += channels;
  }
}

template <int kPitch>
void outer_product_of_pitch(const OuterProduct& product) {
  if (product.packets == 1) return split_channels<1, kPitch>(product);
  split_channels<2, kPitch>(product);
}

void outer_product(const OuterProduct& product) {
  switch (product.pixel_pitch) {
    case 1:
      return outer_product_of_pitch<1>(product);
    case 4:
      return outer_product_of_pitch<4>(product);
    default:
      return outer_product_of_pitch<kBlock>(product);
  }
}

}  // namespace
}  // namespace imslam::nn::kernels
