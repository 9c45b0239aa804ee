#pragma once

#include <optional>
#include <string>
#include <vector>

#include "pgo/graph_data.hpp"
#include "pgo/options.hpp"
#include "slam/base/solve_report.hpp"
#include "slam/system/measurements.hpp"
#include "slam/system/slam_options.hpp"
#include "slam/system/slam_result.hpp"

namespace imslam::system {

/// What the graph over a whole sequence says.
struct BatchEstimate {
  pgo::GraphData graph;  ///< one state per frame
  pgo::GraphOptions graph_options;
  SolveReport report;
  bool inertial = false;
  Estimate disparity_offset_px;
  std::optional<Estimate> focal_error;  ///< [1]
  std::optional<Estimate> time_offset_s;
  std::optional<VectorEstimate> camera_rotation;  ///< [rad]
  std::optional<ShapeEstimate> gyro_shape;        ///< [1]
  std::vector<float> position_sigma_m;            ///< per frame; empty if not asked for
  std::vector<bool> imu_gap;   ///< per frame: a gap or saturation since the one before
  std::vector<bool> conflict;  ///< per frame: see rotation_conflicts()
  std::vector<bool> covered;   ///< per frame: measured, not extrapolated
  std::vector<std::string> warnings;
};

/// Solves the pose-velocity graph of all measurements.
///
/// `disparity_offset` is what the front end knows of the rectification error. With an IMU the start
/// comes from gyro alignment and visual-inertial initialisation, never from ground truth; where
/// that fails the graph is visual only and a warning says why. The IMU is integrated anew at the
/// biases found until they stand still. Where the IMU bridges what vision does not see, frames
/// count as covered for two seconds: its errors grow with the cube of the time.
///
/// Where vision and gyro contradict each other (rotation_conflicts()) the graph is solved again
/// without the motions of vision there.
BatchEstimate estimate_batch(const Measurements& measurements,
                             const Estimate& disparity_offset,
                             const SlamOptions& options);

}  // namespace imslam::system
