#include "pgo/relative_pose_factor.hpp"

namespace imslam::pgo {

using lie::SE3d;

RelativePoseFactor::RelativePoseFactor(const RelativeMotion& motion,
                                       const Matrix6& sqrt_information)
    : T_body0_body1_(motion.T_body0_body1),
      J_disparity_offset_(motion.J_disparity_offset),
      J_focal_error_(motion.J_focal_error),
      disparity_offset_(motion.disparity_offset),
      sqrt_information_(sqrt_information) {}

RelativePoseFactor::Vector6 RelativePoseFactor::residual(const SE3d& T_world_body0,
                                                         const SE3d& T_world_body1,
                                                         double disparity_offset,
                                                         double focal_error) const {
  const SE3d measured = T_body0_body1_ * SE3d::exp(shift(disparity_offset, focal_error));
  const SE3d error = measured.inverse() * (T_world_body0.inverse() * T_world_body1);
  return sqrt_information_ * error.log();
}

RelativePoseFactor::Linearization RelativePoseFactor::linearize(const SE3d& T_world_body0,
                                                                const SE3d& T_world_body1,
                                                                double disparity_offset,
                                                                double focal_error,
                                                                bool want_measurement) const {
  const Vector6 tau = shift(disparity_offset, focal_error);
  const SE3d exp_shift = SE3d::exp(tau);
  const SE3d T_body0_body1 = T_world_body0.inverse() * T_world_body1;
  const SE3d error = (T_body0_body1_ * exp_shift).inverse() * T_body0_body1;
  const Vector6 e = error.log();
  const Matrix6& W = sqrt_information_;

  // Log(E Exp(tau)) = e + Jr^-1(e) tau, and T0 Exp(tau) acts as T1 Exp(-Ad(T1^-1 T0) tau).
  // M Exp(tau) puts Exp(-tau) to the left of the error: e - Jl^-1(e) tau.
  Linearization result;
  result.residual = W * e;
  result.J_pose1 = W * SE3d::right_jacobian_inverse(e);
  result.J_pose0 = -result.J_pose1 * T_body0_body1.inverse().adjoint();
  result.J_disparity_offset.setZero();
  result.J_focal_error.setZero();
  result.J_measurement.setZero();
  if (!want_measurement) return result;
  const Matrix6 W_J_left_inverse = W * SE3d::left_jacobian_inverse(e);
  const Matrix6 W_J_shift = -W_J_left_inverse * SE3d::right_jacobian(tau);
  result.J_disparity_offset = W_J_shift * J_disparity_offset_;
  result.J_focal_error = W_J_shift * J_focal_error_;
  result.J_measurement = -W_J_left_inverse * exp_shift.inverse().adjoint();
  return result;
}

bool RelativePoseFactor::Evaluate(double const* const* parameters,
                                  double* residuals,
                                  double** jacobians) const {
  const SE3d T_world_body0 = pose_from_block(parameters[0]);
  const SE3d T_world_body1 = pose_from_block(parameters[1]);
  Eigen::Map<Vector6> r(residuals);
  if (jacobians == nullptr) {
    r = residual(T_world_body0, T_world_body1, *parameters[2], *parameters[3]);
    return r.allFinite();
  }
  const bool calibrating = jacobians[2] != nullptr || jacobians[3] != nullptr;
  const Linearization at =
      linearize(T_world_body0, T_world_body1, *parameters[2], *parameters[3], calibrating);
  r = at.residual;
  if (jacobians[0] != nullptr) pose_jacobian_to_block(at.J_pose0, parameters[0], jacobians[0]);
  if (jacobians[1] != nullptr) pose_jacobian_to_block(at.J_pose1, parameters[1], jacobians[1]);
  if (jacobians[2] != nullptr) Eigen::Map<Vector6>(jacobians[2], 6) = at.J_disparity_offset;
  if (jacobians[3] != nullptr) Eigen::Map<Vector6>(jacobians[3], 6) = at.J_focal_error;
  return r.allFinite();
}

}  // namespace imslam::pgo
