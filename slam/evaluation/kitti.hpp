#pragma once

#include <cstddef>
#include <string>
#include <vector>

#include "slam/sensors/trajectory.hpp"

namespace imslam::evaluation {

/// Error of the motion over one stretch of the path, per metre.
struct DriftSegment {
  std::size_t first = 0;        ///< pose where the stretch begins
  double rotation_per_m = 0.0;  ///< [rad/m]
  double translation = 0.0;     ///< fraction of the length
  double length_m = 0.0;        ///< nominal length [m]
  double speed_mps = 0.0;       ///< [m/s]
};

/// Mean over the segments of one length, or of one band of speed.
struct DriftBin {
  double key = 0.0;  ///< length [m] or speed [m/s]
  std::size_t count = 0;
  double t_percent = 0.0;
  double r_deg_per_100m = 0.0;
};

struct Drift {
  std::vector<DriftSegment> segments;
  double t_rel_percent = 0.0;
  double r_rel_deg_per_100m = 0.0;
  std::vector<DriftBin> by_length;  ///< at least three segments each, as in the devkit's plots
  std::vector<DriftBin> by_speed;   ///< 2..24 m/s in steps of 2, each +-2 m/s wide
};

struct DriftOptions {
  std::vector<double> lengths_m = {100, 200, 300, 400, 500, 600, 700, 800};
  std::size_t step = 10;          ///< a stretch begins at every step-th pose
  double frame_interval_s = 0.1;  ///< for the speed
};

/// KITTI odometry benchmark, no alignment. d = distance along the reference Q; a stretch from i
/// ends at the first j with d_j > d_i + L:
///
///   E = (P_i^-1 P_j)^-1 (Q_i^-1 Q_j),   r = angle(R(E)) / L,   t = |t(E)| / L
///
/// t_rel, r_rel: means over all segments. Source: evaluate_odometry.cpp of the KITTI devkit, in
/// doubles. Paths are paired pose by pose. No segments if the path is too short.
Drift kitti_drift(const PosePath& reference,
                  const PosePath& estimate,
                  const DriftOptions& options = {});

/// The same for paths of any length: stretches of 10, 20, 30, 40, 50 % of the reference's length,
/// beginning at every pose (the segments of rpg_trajectory_evaluation).
Drift sub_trajectory_drift(const PosePath& reference, const PosePath& estimate);

/// The devkit's errors/NN.txt: "first rotation translation length speed" per segment.
std::string devkit_errors(const Drift& drift);

}  // namespace imslam::evaluation
