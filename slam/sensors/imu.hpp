#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <vector>

namespace imslam {

/// One reading of the inertial sensor, in the body frame.
struct ImuSample {
  std::int64_t time_ns = 0;
  Eigen::Vector3d angular_velocity = Eigen::Vector3d::Zero();     ///< [rad/s]
  Eigen::Vector3d linear_acceleration = Eigen::Vector3d::Zero();  ///< [m/s^2], specific force:
                                                                  ///< +9.81 upwards at rest
  /// White noise on top of the datasheet's, as densities squared; a correction states it.
  Eigen::Vector3d gyro_variance = Eigen::Vector3d::Zero();   ///< [(rad/s)^2/Hz]
  Eigen::Vector3d accel_variance = Eigen::Vector3d::Zero();  ///< [(m/s^2)^2/Hz]
};

/// Slowly varying offsets: reading = truth + bias + noise.
struct ImuBias {
  Eigen::Vector3d gyro = Eigen::Vector3d::Zero();   ///< [rad/s]
  Eigen::Vector3d accel = Eigen::Vector3d::Zero();  ///< [m/s^2]
};

/// Datasheet noise in continuous time, as in EuRoC and Kalibr files, the sensor's range, and how
/// large its biases may be before anything was seen (no such file states them).
struct ImuNoise {
  double gyro_noise_density = 1.7e-4;   ///< [rad/s/sqrt(Hz)]
  double gyro_random_walk = 2.0e-5;     ///< [rad/s^2/sqrt(Hz)]
  double accel_noise_density = 2.0e-3;  ///< [m/s^2/sqrt(Hz)]
  double accel_random_walk = 3.0e-3;    ///< [m/s^3/sqrt(Hz)]
  double rate_hz = 200.0;               ///< [Hz]
  double gyro_range = 34.9;             ///< [rad/s], readings at or beyond it are saturated
  double accel_range = 157.0;           ///< [m/s^2]
  double gyro_bias_sigma = 0.1;         ///< [rad/s]
  double accel_bias_sigma = 0.2;        ///< [m/s^2]
};

}  // namespace imslam
