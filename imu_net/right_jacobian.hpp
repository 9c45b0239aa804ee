#pragma once

#include <Eigen/Core>

namespace imslam::imu {

/// The vector d . axial(X) = <X, [d]x> for every d.
inline Eigen::Vector3d axial(const Eigen::Matrix3d& X) {
  return {X(2, 1) - X(1, 2), X(0, 2) - X(2, 0), X(1, 0) - X(0, 1)};
}

/// The right Jacobian of SO3, as lie::SO3d::right_jacobian(), but without trigonometry for angles
/// as small as those of an integration step:
///
///   Jr(w) = I - alpha [w]x + beta [w]x^2,  alpha = (1 - cos t) / t^2,  beta = (t - sin t) / t^3,
///   t = |w|
Eigen::Matrix3d right_jacobian(const Eigen::Vector3d& w);

/// dL/dw, where D = dL/dJr.
Eigen::Vector3d right_jacobian_gradient(const Eigen::Vector3d& w, const Eigen::Matrix3d& D);

}  // namespace imslam::imu
