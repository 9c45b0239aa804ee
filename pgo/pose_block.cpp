#include "pgo/pose_block.hpp"

namespace imslam::pgo {

PosePlusJacobian pose_plus_jacobian(const double* block) {
  const Eigen::Map<const Eigen::Quaterniond> q(block + 3);
  PosePlusJacobian J = PosePlusJacobian::Zero();
  J.topLeftCorner<3, 3>() = q.toRotationMatrix();
  // q * [theta/2, 1]
  J.block<3, 3>(3, 3) = 0.5 * (q.w() * Eigen::Matrix3d::Identity() + lie::skew(q.vec()));
  J.bottomRightCorner<1, 3>() = -0.5 * q.vec().transpose();
  return J;
}

PoseMinusJacobian pose_minus_jacobian(const double* block) {
  const Eigen::Map<const Eigen::Quaterniond> q(block + 3);
  PoseMinusJacobian J = PoseMinusJacobian::Zero();
  J.topLeftCorner<3, 3>() = q.toRotationMatrix().transpose();
  J.block<3, 3>(3, 3) = 2.0 * (q.w() * Eigen::Matrix3d::Identity() - lie::skew(q.vec()));
  J.bottomRightCorner<3, 1>() = -2.0 * q.vec();
  return J;
}

bool PoseManifold::Plus(const double* x, const double* tau, double* x_plus_tau) const {
  const Eigen::Map<const lie::SE3d::Tangent> step(tau);
  pose_to_block(pose_from_block(x) * lie::SE3d::exp(step), x_plus_tau);
  return true;
}

bool PoseManifold::PlusJacobian(const double* x, double* jacobian) const {
  Eigen::Map<PosePlusJacobian> J(jacobian);
  J = pose_plus_jacobian(x);
  return true;
}

bool PoseManifold::Minus(const double* y, const double* x, double* y_minus_x) const {
  Eigen::Map<lie::SE3d::Tangent> difference(y_minus_x);
  difference = (pose_from_block(x).inverse() * pose_from_block(y)).log();
  return true;
}

bool PoseManifold::MinusJacobian(const double* x, double* jacobian) const {
  Eigen::Map<PoseMinusJacobian> J(jacobian);
  J = pose_minus_jacobian(x);
  return true;
}

}  // namespace imslam::pgo
