#pragma once

#include <cmath>
#include <cstdint>

namespace imslam {

inline constexpr double kNanosecondsPerSecond = 1e9;

/// Duration in seconds of a difference of two stamps. Never call it on an absolute stamp: doubles
/// resolve only 256 ns there.
inline double to_seconds(std::int64_t duration_ns) {
  return static_cast<double>(duration_ns) / kNanosecondsPerSecond;
}

/// Nearest nanosecond to a duration [s].
inline std::int64_t to_nanoseconds(double duration_s) {
  return static_cast<std::int64_t>(std::llround(duration_s * kNanosecondsPerSecond));
}

}  // namespace imslam
