#pragma once

#include <Eigen/Core>

#include "slam/lie/se3.hpp"

namespace imslam {

/// Rectified pinhole pair: rows of left and right correspond, u_right = u_left - disparity.
///
///   u = fx x/z + cx,   v = fy y/z + cy,   disparity = fx baseline / z     (p_left = [x y z])
///
/// Camera axes: x right, y down, z forward. T_body_left belongs to the *rectified* left camera.
struct StereoCamera {
  int width = 0;            ///< [px]
  int height = 0;           ///< [px]
  double fx = 0.0;          ///< [px]
  double fy = 0.0;          ///< [px]
  double cx = 0.0;          ///< [px]
  double cy = 0.0;          ///< [px]
  double baseline_m = 0.0;  ///< [m], positive
  lie::SE3d T_body_left;    ///< body = IMU, or the left camera where there is no IMU

  /// [u v disparity] of a point in front of the camera (z > 0).
  Eigen::Vector3d project(const Eigen::Vector3d& p_left) const {
    const double inverse_z = 1.0 / p_left.z();
    return {fx * p_left.x() * inverse_z + cx, fy * p_left.y() * inverse_z + cy,
            fx * baseline_m * inverse_z};
  }

  /// The point [m] seen at [u v disparity] (disparity > 0); inverse of project().
  Eigen::Vector3d back_project(const Eigen::Vector3d& uvd) const {
    const double z = fx * baseline_m / uvd.z();
    return {(uvd.x() - cx) / fx * z, (uvd.y() - cy) / fy * z, z};
  }
};

}  // namespace imslam
