#pragma once

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <vector>

#include "slam/nn/kernels/workspace.hpp"

namespace imslam::nn::testing {

/// An array of NaN between two zones of NaN: what is read before it was written, or read outside,
/// spoils the result; what is written outside is found.
class GuardedArray {
 public:
  explicit GuardedArray(std::size_t size)
      : memory_(size + 2 * kGuard, std::numeric_limits<float>::quiet_NaN()), size_(size) {}
  explicit GuardedArray(const std::vector<float>& values) : GuardedArray(values.size()) {
    std::copy(values.begin(), values.end(), data());
  }

  float* data() { return memory_.data() + kGuard; }
  std::vector<float> values() const {
    const auto first = memory_.begin() + static_cast<std::ptrdiff_t>(kGuard);
    return {first, first + static_cast<std::ptrdiff_t>(size_)};
  }
  bool guards_are_intact() const {
    const auto is_nan = [](float value) { return std::isnan(value); };
    const auto guard = static_cast<std::ptrdiff_t>(kGuard);
    return std::all_of(memory_.begin(), memory_.begin() + guard, is_nan) &&
           std::all_of(memory_.end() - guard, memory_.end(), is_nan);
  }

 private:
  static constexpr std::size_t kGuard = 67;  // odd: the array is not aligned
  std::vector<float> memory_;
  std::size_t size_;
};

/// Fills the scratch memory with NaN, as it may be after other calls.
inline void spoil(Workspace& workspace) {
  constexpr std::size_t kFloats = 1 << 18;
  const float nan = std::numeric_limits<float>::quiet_NaN();
  for (std::size_t slot = 0; slot < 2; ++slot)
    std::fill_n(workspace.buffer(slot, kFloats), kFloats, nan);
  const Workspace::Lease first(workspace, kFloats);
  const Workspace::Lease second(workspace, kFloats);
  std::fill_n(first.data(), kFloats, nan);
  std::fill_n(second.data(), kFloats, nan);
}

}  // namespace imslam::nn::testing
