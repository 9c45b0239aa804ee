#pragma once

#include <vector>

#include "slam/sensors/motion.hpp"

namespace imslam::pgo {

/// The gyro bias [rad/s] that brings the IMU's rotations to those of vision:
///
///   min_b sum_i rho(|Log(dR_i(b)^T R_i)|^2),   Gauss-Newton, weighted, Huber
///
/// over the intervals where both are valid. `rotation_floor` [rad] is added to vision's sigma.
Eigen::Vector3d fit_gyro_bias(const std::vector<RelativeMotion>& visual,
                              const std::vector<ImuMotion>& inertial,
                              double rotation_floor);

}  // namespace imslam::pgo
