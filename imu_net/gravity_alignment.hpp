#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <optional>

#include "imu_net/imu_buffer.hpp"
#include "imu_net/static_detector.hpp"
#include "slam/lie/so3.hpp"
#include "slam/sensors/imu.hpp"

namespace imslam::imu {

/// Attitude and gyro bias read off a body at rest.
struct GravityAlignment {
  lie::SO3d R_world_body;  ///< turns the mean force upwards on the shortest way; heading is free
  double tilt_std = 0.0;   ///< [rad] of roll and pitch, accelerometer bias included
  ImuBias bias;            ///< gyro: mean rate; accel: zero (not observable at rest)
  Eigen::Matrix3d gyro_bias_covariance = Eigen::Matrix3d::Identity();  ///< [rad^2/s^2]
};

/// The shortest rotation that turns `force_body` (specific force at rest, not zero) upwards.
lie::SO3d upright_rotation(const Eigen::Vector3d& force_body);

/// Roll, pitch and gyro bias from [time0, time0 + window_s] in IMU time; empty unless the body
/// rests there. accel_bias_std [m/s^2]: what the accelerometer's bias may be.
std::optional<GravityAlignment> align_to_gravity(ImuRange samples,
                                                 std::int64_t time0_ns,
                                                 const ImuNoise& noise,
                                                 const StaticDetectorOptions& options = {},
                                                 double window_s = 1.0,
                                                 double accel_bias_std = 0.1);

}  // namespace imslam::imu
