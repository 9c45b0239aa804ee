#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <cstdint>

#include "slam/nn/kernels/kernel_table.hpp"

/// Included only by the units of one instruction set, each of which first renames Eigen, so that
/// inline functions compiled for different instructions have different names. Everything here lies
/// in an unnamed namespace for the same reason.
namespace imslam::nn::kernels {
namespace {

using Eigen::internal::padd;
using Eigen::internal::pcmp_lt;
using Eigen::internal::ploadu;
using Eigen::internal::pmadd;
using Eigen::internal::pmul;
using Eigen::internal::predux;
using Eigen::internal::pselect;
using Eigen::internal::pset1;
using Eigen::internal::pstoreu;
using Eigen::internal::pzero;

using Packet = Eigen::internal::packet_traits<float>::type;
using Packet4 = Eigen::internal::Packet4f;
constexpr int kLanes = Eigen::internal::packet_traits<float>::size;
/// Registers of packets: how large a tile may be.
constexpr int kRegisters = kLanes == 16 ? 32 : 16;
/// Most packets of output channels in a group; a tile of more was slower wherever it was tried.
constexpr int kMostPackets = 2;

EIGEN_ALWAYS_INLINE Packet load(const float* from) { return ploadu<Packet>(from); }

EIGEN_ALWAYS_INLINE Packet load_lanes(const float* from, int lanes) {
  if (lanes == kLanes) return load(from);
#if defined(EIGEN_VECTORIZE_AVX512)
  return ploadu<Packet>(from, static_cast<std::uint16_t>((1U << lanes) - 1U));
#else
  float all[kLanes] = {};
  for (int i = 0; i < lanes; ++i) all[i] = from[i];
  return load(all);
#endif
}

EIGEN_ALWAYS_INLINE void store_lanes(float* to, const Packet& packet, int lanes) {
  if (lanes == kLanes) return pstoreu(to, packet);
#if defined(EIGEN_VECTORIZE_AVX512)
  pstoreu(to, packet, static_cast<std::uint16_t>((1U << lanes) - 1U));
#else
  float all[kLanes];
  pstoreu(all, packet);
  for (int i = 0; i < lanes; ++i) to[i] = all[i];
#endif
}

}  // namespace
}  // namespace imslam::nn::kernels
