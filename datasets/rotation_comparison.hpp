#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <vector>

#include "datasets/visual_probe.hpp"
#include "slam/lie/so3.hpp"
#include "slam/sensors/imu.hpp"

namespace imslam::datasets {

/// How the rotations that vision and gyro see of the same intervals fit together.
///
///   v_k = R_left_body ( integral of w over [t_k + d, t_k+1 + d] ) + constant (bias) + noise
///
/// with the time offset d: t_imu = t_camera + d.
struct RotationComparison {
  int intervals = 0;           ///< used, after outliers were left out
  double angle_rad = 0.0;      ///< [rad] sum of the gyro's rotations, its mean rate removed
  double time_offset_s = 0.0;  ///< [s] where both agree best
  double correlation = 0.0;    ///< with the best rotation between the sensors, 1 = perfect
  double calibrated = 0.0;     ///< correlation with the calibrated R_left_body
  double inverted = 0.0;       ///< correlation with its inverse
  double scale = 1.0;          ///< vision rotates by this factor more than the gyro
  double planarity = 0.0;      ///< 0: one axis only; 1: all axes alike. Second singular value ratio
  lie::SO3d R_left_body;       ///< best rotation; means little if planarity is near 0
  bool valid = false;          ///< enough common intervals and rotation to say anything
};

/// Least squares (Kabsch) over a time offset searched within +-0.15 s, twice, the second time
/// without intervals that fit worse than four times the median.
RotationComparison compare_rotations(const std::vector<VisualRotation>& vision,
                                     const std::vector<ImuSample>& imu,
                                     const lie::SO3d& R_body_left);

}  // namespace imslam::datasets
