#include "pgo/relative_pose_factor.hpp"

namespace imslam::pgo {

using lie::SE3d;

RelativePoseFactor::RelativePoseFactor(const RelativeMotion& motion,
                                       const Matrix6& sqrt_information,
                                       const SE3d& T_body_left)
    : T_body0_body1_(motion.T_body0_body1),
      T_body_left_(T_body_left),
      J_disparity_offset_(motion.J_disparity_offset),
      J_focal_error_(motion.J_focal_error),
      disparity_offset_(motion.disparity_offset),
      sqrt_information_(sqrt_information) {}

SE3d RelativePoseFactor::turn(const Eigen::Vector3d& camera_rotation) const {
  if (camera_rotation.isZero(0.0)) return {};
  return T_body_left_ * SE3d(lie::SO3d::exp(camera_rotation), Eigen::Vector3d::Zero()) *
         T_body_left_.inverse();
}

RelativePoseFactor::Vector6 RelativePoseFactor::residual(
    const SE3d& T_world_body0,
    const SE3d& T_world_body1,
    const VisualCalibration& calibration) const {
  const SE3d C = turn(calibration.camera_rotation);
  const SE3d measured = C * T_body0_body1_ * C.inverse() * SE3d::exp(shift(calibration));
  const SE3d error = measured.inverse() * (T_world_body0.inverse() * T_world_body1);
  return sqrt_information_ * error.log();
}

RelativePoseFactor::Linearization RelativePoseFactor::linearize(
    const SE3d& T_world_body0,
    const SE3d& T_world_body1,
    const VisualCalibration& calibration,
    bool want_measurement) const {
  const Vector6 tau = shift(calibration);
  const SE3d exp_shift = SE3d::exp(tau);
  const SE3d C = turn(calibration.camera_rotation);
  const SE3d T_body0_body1 = T_world_body0.inverse() * T_world_body1;
  const SE3d error = (C * T_body0_body1_ * C.inverse() * exp_shift).inverse() * T_body0_body1;
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
  result.J_camera_rotation.setZero();
  result.J_measurement.setZero();
  if (!want_measurement) return result;
  const Matrix6 W_J_left_inverse = W * SE3d::left_jacobian_inverse(e);
  const Matrix6 W_J_shift = -W_J_left_inverse * SE3d::right_jacobian(tau);
  result.J_disparity_offset = W_J_shift * J_disparity_offset_;
  result.J_focal_error = W_J_shift * J_focal_error_;
  // C T Exp(x) C^-1 Exp(tau) = C T C^-1 Exp(tau) Exp(Ad(Exp(-tau) C) x). A further turn of the
  // camera by Jr(c) dc is one of the body by xi to the right of C: T becomes Exp(xi) T Exp(-xi),
  // x = (Ad(T^-1) - 1) xi.
  result.J_measurement = -W_J_left_inverse * (exp_shift.inverse() * C).adjoint();
  const Matrix63 xi = T_body_left_.adjoint().rightCols<3>() *
                      lie::SO3d::right_jacobian(calibration.camera_rotation);
  result.J_camera_rotation = result.J_measurement * (T_body0_body1_.inverse().adjoint() * xi - xi);
  return result;
}

bool RelativePoseFactor::Evaluate(double const* const* parameters,
                                  double* residuals,
                                  double** jacobians) const {
  const SE3d T_world_body0 = pose_from_block(parameters[0]);
  const SE3d T_world_body1 = pose_from_block(parameters[1]);
  const VisualCalibration calibration{*parameters[2], *parameters[3],
                                      Eigen::Map<const Eigen::Vector3d>(parameters[4])};
  Eigen::Map<Vector6> r(residuals);
  if (jacobians == nullptr) {
    r = residual(T_world_body0, T_world_body1, calibration);
    return r.allFinite();
  }
  const bool calibrating =
      jacobians[2] != nullptr || jacobians[3] != nullptr || jacobians[4] != nullptr;
  const Linearization at = linearize(T_world_body0, T_world_body1, calibration, calibrating);
  r = at.residual;
  if (jacobians[0] != nullptr) pose_jacobian_to_block(at.J_pose0, parameters[0], jacobians[0]);
  if (jacobians[1] != nullptr) pose_jacobian_to_block(at.J_pose1, parameters[1], jacobians[1]);
  if (jacobians[2] != nullptr) Eigen::Map<Vector6>(jacobians[2], 6) = at.J_disparity_offset;
  if (jacobians[3] != nullptr) Eigen::Map<Vector6>(jacobians[3], 6) = at.J_focal_error;
  if (jacobians[4] != nullptr) {
    Eigen::Map<Eigen::Matrix<double, 6, 3, Eigen::RowMajor>> J(jacobians[4]);
    J = at.J_camera_rotation;
  }
  return r.allFinite();
}

}  // namespace imslam::pgo
