#include "pgo/paper_factors.hpp"

namespace imslam::pgo {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;
using Matrix36 = Eigen::Matrix<double, 3, 6>;
using Block3 = Eigen::Map<Eigen::Matrix<double, 3, 3, Eigen::RowMajor>>;

/// Jacobian of w p with respect to the right tangent of a pose.
Matrix36 position_jacobian(const lie::SE3d& pose, double weight) {
  Matrix36 J;
  J << weight * pose.rotation().matrix(), Matrix3d::Zero();
  return J;
}

}  // namespace

RotationStepFactor::RotationStepFactor(const lie::SO3d& dR, double weight)
    : dR_inverse_(dR.inverse()), weight_(weight) {}

bool RotationStepFactor::Evaluate(double const* const* parameters,
                                  double* residuals,
                                  double** jacobians) const {
  const lie::SO3d R0_inverse = pose_from_block(parameters[0]).rotation().inverse();
  const lie::SO3d step = R0_inverse * pose_from_block(parameters[1]).rotation();
  const Vector3d e = (dR_inverse_ * step).log();
  Eigen::Map<Vector3d> r(residuals);
  r = weight_ * e;
  if (jacobians != nullptr) {
    const Matrix3d J1 = weight_ * lie::SO3d::right_jacobian_inverse(e);
    Matrix36 J = Matrix36::Zero();
    if (jacobians[0] != nullptr) {
      J.rightCols<3>() = -J1 * step.matrix().transpose();
      pose_jacobian_to_block(J, parameters[0], jacobians[0]);
    }
    if (jacobians[1] != nullptr) {
      J.rightCols<3>() = J1;
      pose_jacobian_to_block(J, parameters[1], jacobians[1]);
    }
  }
  return r.allFinite();
}

VelocityStepFactor::VelocityStepFactor(const Vector3d& dv_world, double weight)
    : dv_world_(dv_world), weight_(weight) {}

bool VelocityStepFactor::Evaluate(double const* const* parameters,
                                  double* residuals,
                                  double** jacobians) const {
  const Eigen::Map<const Vector3d> v0(parameters[0]);
  const Eigen::Map<const Vector3d> v1(parameters[1]);
  Eigen::Map<Vector3d> r(residuals);
  r = weight_ * (dv_world_ - (v1 - v0));
  if (jacobians != nullptr) {
    if (jacobians[0] != nullptr) Block3(jacobians[0], 3, 3) = weight_ * Matrix3d::Identity();
    if (jacobians[1] != nullptr) Block3(jacobians[1], 3, 3) = -weight_ * Matrix3d::Identity();
  }
  return r.allFinite();
}

TranslationVelocityFactor::TranslationVelocityFactor(const Vector3d& dp_world,
                                                     double dt_s,
                                                     double weight)
    : dp_world_(dp_world), dt_s_(dt_s), weight_(weight) {}

bool TranslationVelocityFactor::Evaluate(double const* const* parameters,
                                         double* residuals,
                                         double** jacobians) const {
  const lie::SE3d pose0 = pose_from_block(parameters[0]);
  const Eigen::Map<const Vector3d> v0(parameters[1]);
  const lie::SE3d pose1 = pose_from_block(parameters[2]);
  Eigen::Map<Vector3d> r(residuals);
  r = weight_ * ((pose1.translation() - pose0.translation()) - (v0 * dt_s_ + dp_world_));
  if (jacobians != nullptr) {
    if (jacobians[0] != nullptr) {
      pose_jacobian_to_block(position_jacobian(pose0, -weight_), parameters[0], jacobians[0]);
    }
    if (jacobians[1] != nullptr) {
      Block3(jacobians[1], 3, 3) = -weight_ * dt_s_ * Matrix3d::Identity();
    }
    if (jacobians[2] != nullptr) {
      pose_jacobian_to_block(position_jacobian(pose1, weight_), parameters[2], jacobians[2]);
    }
  }
  return r.allFinite();
}

}  // namespace imslam::pgo
