#include "slam/system/flagged_segments.hpp"

namespace imslam::system {
namespace {

/// Adds the runs of frames from `begin` on for which `flagged` is true.
template <typename Flagged>
void add_stretches(const char* kind,
                   std::size_t begin,
                   std::size_t end,
                   const Flagged& flagged,
                   std::vector<FlaggedSegment>& segments) {
  for (std::size_t i = begin; i < end; ++i) {
    if (!flagged(i)) continue;
    const std::size_t first = i;
    while (i + 1 < end && flagged(i + 1)) ++i;
    segments.push_back({kind, first, i});
  }
}

}  // namespace

std::vector<FlaggedSegment> flagged_segments(const FrameSeries& series) {
  std::vector<FlaggedSegment> segments;
  const auto add = [&](const char* kind, const std::vector<std::uint8_t>& flags) {
    add_stretches(
        kind, 0, flags.size(), [&](std::size_t i) { return flags[i] != 0; }, segments);
  };
  add("degraded", series.degraded);
  add("imu_gap", series.imu_gap);
  add("conflict", series.conflict);
  // The first frame has none to move from.
  add_stretches(
      "no_vision", 1, series.inliers.size(), [&](std::size_t i) { return series.inliers[i] == 0; },
      segments);
  return segments;
}

}  // namespace imslam::system
