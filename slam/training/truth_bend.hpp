#pragma once

#include <Eigen/Core>
#include <array>
#include <cstddef>

#include "imu_net/imu_buffer.hpp"
#include "slam/sensors/imu.hpp"
#include "slam/sensors/trajectory.hpp"

namespace imslam::training {

/// Three poses in order of time.
using PoseTriple = std::array<std::size_t, 3>;

/// What the IMU says about two neighbouring intervals, held against true poses: the rotation of the
/// first one, and the bend of the path, which needs no velocity:
///
///   p2 - p1 - T2 (p1 - p0) / T1 = g T2 (T1 + T2) / 2 + T2 R0 (dv1 - dp1 / T1) + R1 dp2
///
/// residual = [rotation [rad], bend [m]], left side minus right; J: by [gyro bias, accelerometer
/// bias, gravity].
struct Bend {
  Eigen::Matrix<double, 6, 1> residual;
  Eigen::Matrix<double, 6, 9> J;
  Eigen::Matrix<double, 6, 6> covariance;
  bool usable = false;  ///< the readings have no gap there
};

Bend bend(imu::ImuRange samples,
          const ImuNoise& noise,
          const Trajectory& truth,
          const PoseTriple& triple,
          const ImuBias& bias,
          const Eigen::Vector3d& gravity);

}  // namespace imslam::training
