#pragma once

#include <fmt/format.h>

#include <string_view>

#include "slam/base/error.hpp"

namespace imslam::learner {

/// Throws InputError(kUsage) "key: expected low to high, got value".
inline void require_within(std::string_view key, double value, double low, double high) {
  if (value >= low && value <= high) return;
  throw InputError(fmt::format("{}: expected {} to {}, got {}", key, low, high, value),
                   ExitCode::kUsage);
}

}  // namespace imslam::learner
