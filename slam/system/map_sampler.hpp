#pragma once

#include <cstdint>

#include "slam/sensors/calibration.hpp"
#include "slam/sensors/stereo.hpp"
#include "slam/system/map_builder.hpp"
#include "slam/system/slam_options.hpp"
#include "vo_net/visual_odometry.hpp"

namespace imslam::system {

/// Picks a few points of each frame for the map, spread over the image; near ones, for their depth
/// is sure.
class MapSampler {
 public:
  MapSampler(const StereoCamera& camera, const SystemOptions& options);

  void add(const StereoFrame& frame,
           std::uint32_t index,
           const vo::VoOutput& seen,
           MapBuilder& map) const;

 private:
  StereoCamera camera_;
  std::size_t points_per_frame_;
  double min_disparity_px_;
};

}  // namespace imslam::system
