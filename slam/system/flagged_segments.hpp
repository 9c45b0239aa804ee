#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "slam/system/slam_result.hpp"

namespace imslam::system {

/// A stretch of frames to be trusted less.
struct FlaggedSegment {
  const char* kind = "";  ///< degraded, imu_gap, conflict or no_vision
  std::size_t first = 0;  ///< frame
  std::size_t last = 0;   ///< frame, included
};

/// All stretches of a run, kind by kind, in order of time.
///
///   degraded    neither vision nor the IMU covers the frame, or the IMU alone for over two seconds
///   imu_gap     samples are missing or saturated since the frame before
///   conflict    vision and gyro disagree about the rotation to the frame
///   no_vision   no motion was measured to the frame
std::vector<FlaggedSegment> flagged_segments(const FrameSeries& series);

}  // namespace imslam::system
