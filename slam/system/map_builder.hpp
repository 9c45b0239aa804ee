#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <vector>

#include "slam/sensors/trajectory.hpp"

namespace imslam::system {

/// One scene point as seen from a frame.
struct MapPoint {
  Eigen::Vector3f p_left = Eigen::Vector3f::Zero();  ///< [m], in the left camera of `frame`
  std::uint32_t frame = 0;                           ///< index into the trajectory
  std::uint8_t gray = 0;
};

/// The camera as the graph found it.
struct MapCamera {
  lie::SE3d T_body_left;
  double focal_baseline = 0.0;       ///< [px m] of disparities
  double disparity_offset_px = 0.0;  ///< by which they were measured too large
};

/// Collects points while running and puts them into the world once the trajectory, and how the
/// camera sits on the body, are known.
class MapBuilder {
 public:
  void add(const MapPoint& point) { points_.push_back(point); }
  std::size_t size() const { return points_.size(); }

  /// Writes a PCD file (binary, x y z intensity) with one point per cube of side `voxel_m`.
  /// `trajectory` holds T_world_body. Points of frames beyond the trajectory are left out.
  /// Throws InputError(kOutput).
  void write_pcd(const std::filesystem::path& file,
                 const Trajectory& trajectory,
                 const MapCamera& camera,
                 double voxel_m) const;

 private:
  std::vector<MapPoint> points_;
};

}  // namespace imslam::system
