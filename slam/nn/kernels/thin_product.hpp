#pragma once

#include "slam/nn/kernels/packet_types.hpp"

namespace imslam::nn::kernels {
namespace {

constexpr int kThinRows = 4;
constexpr int kThinPackets = 2;

/// Rows x Packets sums stay in registers while the weights stream by once.
template <int kRows, int kPackets>
EIGEN_ALWAYS_INLINE void thin_tile(const ThinProduct& p, int row, int column, int last_lanes) {
  Packet sums[kRows][kPackets];
#pragma GCC unroll 4
  for (int r = 0; r < kRows; ++r) {
#pragma GCC unroll 2
    for (int i = 0; i < kPackets; ++i) sums[r][i] = pzero(Packet());
  }
  const float* w = p.w + column;
  const float* const x = p.x + static_cast<std::ptrdiff_t>(row) * p.inner;
  for (int k = 0; k < p.inner; ++k, w += p.columns) {
    Packet weights[kPackets];
#pragma GCC unroll 2
    for (int i = 0; i < kPackets; ++i) {
      weights[i] = load_lanes(w + i * kLanes, i + 1 == kPackets ? last_lanes : kLanes);
    }
#pragma GCC unroll 4
    for (int r = 0; r < kRows; ++r) {
      const Packet factor = pset1<Packet>(x[static_cast<std::ptrdiff_t>(r) * p.inner + k]);
#pragma GCC unroll 2
      for (int i = 0; i < kPackets; ++i) sums[r][i] = pmadd(factor, weights[i], sums[r][i]);
    }
  }
#pragma GCC unroll 4
  for (int r = 0; r < kRows; ++r) {
    float* const y = p.y + static_cast<std::ptrdiff_t>(row + r) * p.columns + column;
#pragma GCC unroll 2
    for (int i = 0; i < kPackets; ++i) {
      store_lanes(y + i * kLanes, sums[r][i], i + 1 == kPackets ? last_lanes : kLanes);
    }
  }
}

template <int kRows>
EIGEN_ALWAYS_INLINE void thin_rows(const ThinProduct& p, int row) {
  constexpr int kWidth = kThinPackets * kLanes;
  int column = 0;
  for (; column + kWidth <= p.columns; column += kWidth) {
    thin_tile<kRows, kThinPackets>(p, row, column, kLanes);
  }
  for (; column < p.columns; column += kLanes) {
    const int left = p.columns - column;
    thin_tile<kRows, 1>(p, row, column, left < kLanes ? left : kLanes);
  }
}

void thin_product(const ThinProduct& p) {
  int row = 0;
  for (; row + kThinRows <= p.rows; row += kThinRows) thin_rows<kThinRows>(p, row);
  switch (p.rows - row) {
    case 3:
      return thin_rows<3>(p, row);
    case 2:
      return thin_rows<2>(p, row);
    case 1:
      return thin_rows<1>(p, row);
    default:
      return;
  }
}

}  // namespace
}  // namespace imslam::nn::kernels
