#include "pgo/prior_factors.hpp"

#include <cmath>

namespace imslam::pgo {

using lie::SE3d;
using lie::SO3d;

PosePriorFactor::PosePriorFactor(const SE3d& T_world_body, const Matrix6& sqrt_information)
    : T_body_world_(T_world_body.inverse()), sqrt_information_(sqrt_information) {}

bool PosePriorFactor::Evaluate(double const* const* parameters,
                               double* residuals,
                               double** jacobians) const {
  const SE3d::Tangent e = (T_body_world_ * pose_from_block(parameters[0])).log();
  Eigen::Map<SE3d::Tangent> r(residuals);
  r = sqrt_information_ * e;
  if (jacobians != nullptr && jacobians[0] != nullptr) {
    const Matrix6 J = sqrt_information_ * SE3d::right_jacobian_inverse(e);
    pose_jacobian_to_block(J, parameters[0], jacobians[0]);
  }
  return r.allFinite();
}

AnchorFactor::AnchorFactor(const SE3d& T_world_body, double sigma_position_m, double sigma_yaw_rad)
    : T_world_body_(T_world_body),
      weight_position_(1.0 / sigma_position_m),
      weight_yaw_(1.0 / sigma_yaw_rad) {}

bool AnchorFactor::Evaluate(double const* const* parameters,
                            double* residuals,
                            double** jacobians) const {
  const SE3d pose = pose_from_block(parameters[0]);
  const Eigen::Vector3d turn = (pose.rotation() * T_world_body_.rotation().inverse()).log();
  Eigen::Map<Eigen::Vector4d> r(residuals);
  r.head<3>() = weight_position_ * (pose.translation() - T_world_body_.translation());
  r(3) = weight_yaw_ * turn.z();
  if (jacobians != nullptr && jacobians[0] != nullptr) {
    Eigen::Matrix<double, 4, 6> J = Eigen::Matrix<double, 4, 6>::Zero();
    J.topLeftCorner<3, 3>() = weight_position_ * pose.rotation().matrix();
    // R Exp(theta) R_prior^T = Exp(turn) Exp(R_prior theta)
    const Eigen::Matrix3d J_turn =
        SO3d::right_jacobian_inverse(turn) * T_world_body_.rotation().matrix();
    J.bottomRightCorner<1, 3>() = weight_yaw_ * J_turn.row(2);
    pose_jacobian_to_block(J, parameters[0], jacobians[0]);
  }
  return r.allFinite();
}

BiasWalkFactor::BiasWalkFactor(double gyro_random_walk, double accel_random_walk, double dt_s) {
  weight_.head<3>().setConstant(1.0 / (gyro_random_walk * std::sqrt(dt_s)));
  weight_.tail<3>().setConstant(1.0 / (accel_random_walk * std::sqrt(dt_s)));
}

bool BiasWalkFactor::Evaluate(double const* const* parameters,
                              double* residuals,
                              double** jacobians) const {
  const Eigen::Map<const Vector6> b0(parameters[0]);
  const Eigen::Map<const Vector6> b1(parameters[1]);
  Eigen::Map<Vector6> r(residuals);
  r = weight_.cwiseProduct(b1 - b0);
  using Block = Eigen::Map<Eigen::Matrix<double, 6, 6, Eigen::RowMajor>>;
  if (jacobians != nullptr) {
    if (jacobians[0] != nullptr) Block(jacobians[0], 6, 6) = (-weight_).asDiagonal();
    if (jacobians[1] != nullptr) Block(jacobians[1], 6, 6) = weight_.asDiagonal();
  }
  return r.allFinite();
}

}  // namespace imslam::pgo
