#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "pgo/graph_data.hpp"
#include "pgo/options.hpp"
#include "slam/base/solve_report.hpp"
#include "slam/sensors/device_calibration.hpp"
#include "slam/sensors/trajectory.hpp"
#include "slam/system/front_end.hpp"
#include "slam/system/map_builder.hpp"
#include "slam/system/stage_timer.hpp"

namespace imslam::system {

/// A number that was estimated, and how sure it is.
struct Estimate {
  double value = 0.0;
  std::optional<double> sigma;
};

/// The same of a vector, axis by axis.
struct VectorEstimate {
  Eigen::Vector3d value = Eigen::Vector3d::Zero();
  std::optional<Eigen::Vector3d> sigma;
};

/// The same of a gyro's scale and axes: reading = (I + value) true rate + bias.
struct ShapeEstimate {
  Eigen::Matrix3d value = Eigen::Matrix3d::Zero();
  std::optional<Eigen::Matrix3d> sigma;
};

/// What happened on the way; all of it goes into metrics.json.
struct Counters {
  std::size_t frames = 0;
  std::size_t frames_missing = 0;   ///< without a usable pair of images
  std::size_t frames_degraded = 0;  ///< pose extrapolated, or by the IMU alone for over 2 s
  std::size_t vo_failures = 0;      ///< usable images, but no motion found
  std::size_t skip_edges = 0;
  std::size_t loop_edges = 0;  ///< to views seen long before
  std::size_t imu_samples = 0;
  std::size_t imu_dropped = 0;  ///< not finite, repeated or out of order
  std::size_t imu_gaps = 0;     ///< intervals with a gap or saturation
};

/// One value per frame, for plots.
struct FrameSeries {
  std::vector<std::uint16_t> inliers;
  std::vector<std::uint8_t> degraded;
  std::vector<std::uint8_t> imu_gap;    ///< a gap or saturation since the frame before
  std::vector<std::uint8_t> conflict;   ///< vision and gyro disagree about the way from there
  std::vector<float> position_sigma_m;  ///< empty if not asked for
  std::vector<float> frame_ms;
  std::vector<float> memory_mb;
};

/// Everything a run knows at its end.
struct SlamResult {
  Trajectory graph;    ///< T_world_body, world z up where there is an IMU
  Trajectory vo_only;  ///< the odometry alone, laid onto the first pose of `graph`
  Trajectory online;   ///< what the sliding window knew at each frame; empty if it was off
  pgo::GraphData graph_data;
  pgo::GraphOptions graph_options;
  SolveReport solve;
  bool inertial = false;       ///< the IMU took part in the graph
  bool tracking_lost = false;  ///< most of the frames were not measured

  DeviceCalibration device;             ///< that the run used; what follows is beyond it
  Estimate disparity_offset_px;         ///< but this one, and the time offset, as a whole
  std::optional<Estimate> focal_error;  ///< [1], empty without a gyro to compare with
  std::optional<Estimate> time_offset_s;
  std::optional<VectorEstimate> camera_rotation;  ///< [rad], empty without an IMU to trust
  std::optional<ShapeEstimate> gyro_shape;        ///< [1], empty without a coarse gyro
  double gravity_m_s2 = 0.0;

  Counters counters;
  FrameSeries series;
  StageTimer timing;
  MapBuilder map;
  std::vector<ModelRecord> models;  ///< that took part
  std::vector<std::string> warnings;
};

}  // namespace imslam::system
