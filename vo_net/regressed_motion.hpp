#pragma once

#include <Eigen/Core>

#include "vo_net/pose_head.hpp"
#include "vo_net/scale_corrector.hpp"

namespace imslam::vo {

/// What a pose head says of one motion, in numbers.
struct MotionLook {
  Eigen::Vector3d theta;        ///< rotation vector of R_left0_left1 [rad]
  Eigen::Vector3d direction;    ///< of p_left0_left1, of length 1
  Eigen::Vector3d sigma_theta;  ///< [rad]
  double sigma_direction = 0.0;
};

template <typename S>
MotionLook motion_look(const nn::Tape<S>& tape, const PoseHeadOutput& answer);

/// Covariance of T_left0_left1 = (R, s d), right tangent, and how it comes about:
///
///   C = diag(sigma_d^2 (I - d d^T), sigma_theta^2)      of [d theta]
///   p_covariance = turn (blocks(J C J^T) + sigma_s^2 along) turn^T      [rho theta]
struct RegressedCovariance {
  Eigen::Matrix<double, 6, 6> value;
  Eigen::Matrix<double, 6, 6> J;
  Eigen::Matrix<double, 6, 6> turn;
  Eigen::Matrix3d across;  ///< I - d d^T
  double sigma_direction = 0.0;
  bool direction_counts = true;  ///< false: the points contradict it, its sigma is a constant
};
RegressedCovariance regressed_covariance(const MotionLook& look, const ScaleResult& scale);

/// The same motion of the body.
lie::SE3d in_body(const lie::SE3d& T_left0_left1, const StereoCamera& camera);

}  // namespace imslam::vo
