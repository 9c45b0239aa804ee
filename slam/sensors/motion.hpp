#pragma once

#include <Eigen/Core>
#include <cstdint>

#include "slam/lie/se3.hpp"
#include "slam/sensors/imu.hpp"

namespace imslam {

/// What vision says about the motion between two frames.
///
///   T_body0_body1_true = T_body0_body1 Exp(e),   e ~ N(0, covariance),   tangent [rho theta]
struct RelativeMotion {
  std::int64_t time0_ns = 0;
  std::int64_t time1_ns = 0;
  lie::SE3d T_body0_body1;
  Eigen::Matrix<double, 6, 6> covariance = Eigen::Matrix<double, 6, 6>::Identity();

  /// Where the measurement moves, T Exp(J d), if the constant disparity offset of the stereo
  /// rectification was d [px] more than the one it was computed with.
  Eigen::Matrix<double, 6, 1> J_disparity_offset = Eigen::Matrix<double, 6, 1>::Zero();
  double disparity_offset = 0.0;  ///< [px], the value it was computed with

  /// Likewise if the true focal length was 1 + x times the one it was computed with, fx baseline
  /// (the law of depth) being right: T Exp(J x) [m, rad].
  Eigen::Matrix<double, 6, 1> J_focal_error = Eigen::Matrix<double, 6, 1>::Zero();

  int inliers = 0;
  bool valid = false;  ///< false: nothing was measured, the rest is meaningless
};

/// What the IMU says about the motion between two frames: Forster preintegration.
///
///   dR = R0^T R1,  dv = R0^T (v1 - v0 - g dt),  dp = R0^T (p1 - p0 - v0 dt - g dt^2 / 2)
///   dR(b) = dR Exp(J_dR_bias (b - bias)),  dv(b) = dv + J_dv_bias (b - bias), dp alike
///
/// b = [gyro accel]. The error state of `covariance` is [dR dv dp] in that order: rotation on the
/// right of dR, the others added. Source: Forster et al., "On-Manifold Preintegration", TRO 2017.
struct ImuMotion {
  std::int64_t time0_ns = 0;
  std::int64_t time1_ns = 0;
  double dt_s = 0.0;
  lie::SO3d dR;
  Eigen::Vector3d dv = Eigen::Vector3d::Zero();  ///< [m/s]
  Eigen::Vector3d dp = Eigen::Vector3d::Zero();  ///< [m]
  Eigen::Matrix<double, 9, 9> covariance = Eigen::Matrix<double, 9, 9>::Identity();

  ImuBias bias;  ///< the bias that was subtracted
  Eigen::Matrix<double, 3, 6> J_dR_bias = Eigen::Matrix<double, 3, 6>::Zero();
  Eigen::Matrix<double, 3, 6> J_dv_bias = Eigen::Matrix<double, 3, 6>::Zero();
  Eigen::Matrix<double, 3, 6> J_dp_bias = Eigen::Matrix<double, 3, 6>::Zero();

  /// Change of [dR dv dp] if both ends of the interval move by one second in IMU time: the
  /// camera stamps lag the IMU's clock by `time_offset`, t_imu = t_camera + time_offset.
  Eigen::Matrix<double, 9, 1> J_time_offset = Eigen::Matrix<double, 9, 1>::Zero();
  double time_offset_s = 0.0;  ///< [s], the value it was computed with

  bool degraded = false;  ///< a gap or saturation was bridged; the covariance is inflated
  bool valid = false;     ///< false: no samples cover the interval
};

}  // namespace imslam
