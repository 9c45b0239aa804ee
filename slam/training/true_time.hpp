#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <vector>

namespace imslam::training {

/// Index of the stamp nearest to `time_ns`, if it is at most `tolerance_ns` away. Stamps increase.
inline std::optional<std::size_t> index_near(const std::vector<std::int64_t>& times_ns,
                                             std::int64_t time_ns,
                                             std::int64_t tolerance_ns) {
  const auto next = std::lower_bound(times_ns.begin(), times_ns.end(), time_ns);
  auto best = next;
  if (next == times_ns.end() ||
      (next != times_ns.begin() && time_ns - *std::prev(next) <= *next - time_ns)) {
    if (next == times_ns.begin()) return std::nullopt;
    best = std::prev(next);
  }
  const std::int64_t distance_ns = *best < time_ns ? time_ns - *best : *best - time_ns;
  if (distance_ns > tolerance_ns) return std::nullopt;
  return static_cast<std::size_t>(best - times_ns.begin());
}

}  // namespace imslam::training
