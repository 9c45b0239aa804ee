#include "pgo/imu_factor.hpp"

namespace imslam::pgo {

using Eigen::Matrix3d;
using Eigen::Vector3d;
using lie::SO3d;
using RowMajor3 = Eigen::Matrix<double, 3, 3, Eigen::RowMajor>;

namespace {

/// The turn as a gyro of this shape reads it: Exp((I + S) Log(turn)).
SO3d as_read(const SO3d& turn, const Matrix3d& S) {
  if (S.isZero(0.0)) return turn;
  const Vector3d u = turn.log();
  return SO3d::exp(u + S * u);
}

/// Its derivative by the turn, both on the right.
Matrix3d as_read_jacobian(const SO3d& turn, const Matrix3d& S) {
  if (S.isZero(0.0)) return Matrix3d::Identity();
  const Vector3d u = turn.log();
  return SO3d::right_jacobian(u + S * u) * (Matrix3d::Identity() + S) *
         SO3d::right_jacobian_inverse(u);
}

}  // namespace

ImuFactor::ImuFactor(const ImuMotion& motion,
                     const Matrix9& sqrt_information,
                     double gravity_magnitude)
    : motion_(motion), sqrt_information_(sqrt_information), gravity_magnitude_(gravity_magnitude) {
  bias_ << motion.bias.gyro, motion.bias.accel;
}

ImuFactor::Point ImuFactor::point_from_blocks(double const* const* parameters) {
  Point at;
  at.T_world_body0 = pose_from_block(parameters[0]);
  at.v0_world = Eigen::Map<const Vector3d>(parameters[1]);
  at.T_world_body1 = pose_from_block(parameters[2]);
  at.v1_world = Eigen::Map<const Vector3d>(parameters[3]);
  at.bias = Eigen::Map<const Eigen::Matrix<double, 6, 1>>(parameters[4]);
  at.gravity_direction = Eigen::Map<const Vector3d>(parameters[5]);
  at.time_offset_s = *parameters[6];
  at.gyro_shape = Eigen::Map<const RowMajor3>(parameters[7]);
  return at;
}

ImuFactor::Correction ImuFactor::correct(const Point& at) const {
  const Eigen::Matrix<double, 6, 1> db = at.bias - bias_;
  const double dt_offset = at.time_offset_s - motion_.time_offset_s;
  Correction result;
  result.rotation = motion_.J_dR_bias * db + motion_.J_time_offset.segment<3>(0) * dt_offset;
  result.dv = motion_.dv + motion_.J_dv_bias * db + motion_.J_time_offset.segment<3>(3) * dt_offset;
  result.dp = motion_.dp + motion_.J_dp_bias * db + motion_.J_time_offset.segment<3>(6) * dt_offset;
  return result;
}

ImuFactor::Vector9 ImuFactor::residual(const Point& at) const {
  const double dt = motion_.dt_s;
  const Vector3d g = gravity_magnitude_ * at.gravity_direction;
  const SO3d& R0 = at.T_world_body0.rotation();
  const SO3d R0_inverse = R0.inverse();
  const Correction corrected = correct(at);

  const SO3d dR = motion_.dR * SO3d::exp(corrected.rotation);
  const Vector3d dv = R0_inverse * (at.v1_world - at.v0_world - g * dt);
  const Vector3d dp =
      R0_inverse * (at.T_world_body1.translation() - at.T_world_body0.translation() -
                    at.v0_world * dt - g * (0.5 * dt * dt));
  Vector9 e;
  const SO3d turn = as_read(R0_inverse * at.T_world_body1.rotation(), at.gyro_shape);
  e << (dR.inverse() * turn).log(), dv - corrected.dv, dp - corrected.dp;
  return sqrt_information_.lazyProduct(e);
}

ImuFactor::Linearization ImuFactor::linearize(const Point& at, bool want_measurement) const {
  const double dt = motion_.dt_s;
  const Vector3d g = gravity_magnitude_ * at.gravity_direction;
  const SO3d R0_inverse = at.T_world_body0.rotation().inverse();
  const Matrix3d R0_transposed = R0_inverse.matrix();
  const Matrix3d R0_transposed_R1 = R0_transposed * at.T_world_body1.rotation().matrix();
  const SO3d turn = R0_inverse * at.T_world_body1.rotation();
  const Correction corrected = correct(at);

  const SO3d exp_x = SO3d::exp(corrected.rotation);
  const Vector3d rR = ((motion_.dR * exp_x).inverse() * as_read(turn, at.gyro_shape)).log();
  const Vector3d dv = R0_transposed * (at.v1_world - at.v0_world - g * dt);
  const Vector3d dp =
      R0_transposed * (at.T_world_body1.translation() - at.T_world_body0.translation() -
                       at.v0_world * dt - g * (0.5 * dt * dt));
  const Matrix3d Jr_inverse = SO3d::right_jacobian_inverse(rR);
  const Matrix3d Jl_inverse = Jr_inverse.transpose();  // Jl(r) = Jr(r)^T
  const Matrix3d J_rR_turn = Jr_inverse * as_read_jacobian(turn, at.gyro_shape);
  const Matrix3d J_rR_x = -Jl_inverse * SO3d::right_jacobian(corrected.rotation);
  // Eigen's kernels for large products are slow on these small ones: lazyProduct throughout.
  const Matrix9& W = sqrt_information_;

  Linearization result;
  Vector9 e;
  e << rR, dv - corrected.dv, dp - corrected.dp;
  result.residual = W.lazyProduct(e);

  Matrix96 J6 = Matrix96::Zero();  // T_world_body0: [rho theta]
  J6.block<3, 3>(6, 0) = -Matrix3d::Identity();
  J6.block<3, 3>(0, 3) = -J_rR_turn * R0_transposed_R1.transpose();
  J6.block<3, 3>(3, 3) = lie::skew(dv);
  J6.block<3, 3>(6, 3) = lie::skew(dp);
  result.J_pose0 = W.lazyProduct(J6);

  J6.setZero();  // T_world_body1
  J6.block<3, 3>(6, 0) = R0_transposed_R1;
  J6.block<3, 3>(0, 3) = J_rR_turn;
  result.J_pose1 = W.lazyProduct(J6);

  J6 << J_rR_x * motion_.J_dR_bias, -motion_.J_dv_bias, -motion_.J_dp_bias;
  result.J_bias = W.lazyProduct(J6);

  Matrix93 J3;
  J3 << Matrix3d::Zero(), -R0_transposed, -dt * R0_transposed;
  result.J_v0 = W.lazyProduct(J3);
  J3 << Matrix3d::Zero(), R0_transposed, Matrix3d::Zero();
  result.J_v1 = W.lazyProduct(J3);
  result.J_gravity_direction.setZero();
  result.J_time_offset.setZero();
  result.J_gyro_shape.setZero();
  result.J_measurement.setZero();
  if (!want_measurement) return result;
  J3 << Matrix3d::Zero(), (-gravity_magnitude_ * dt) * R0_transposed,
      (-0.5 * gravity_magnitude_ * dt * dt) * R0_transposed;
  result.J_gravity_direction = W.lazyProduct(J3);

  Vector9 J1 = -motion_.J_time_offset;
  J1.head<3>() = J_rR_x * motion_.J_time_offset.head<3>();
  result.J_time_offset = W.lazyProduct(J1);

  // Row i of S u is row i of S times u.
  const Vector3d u = turn.log();
  const Matrix3d Jr = SO3d::right_jacobian(u + at.gyro_shape * u);
  const Matrix93 J_S_u = W.leftCols<3>().lazyProduct((Jr_inverse * Jr).eval());
  for (int i = 0; i < 3; ++i) {
    result.J_gyro_shape.middleCols<3>(3 * i) = J_S_u.col(i) * u.transpose();
  }

  Matrix9 J9 = -Matrix9::Identity();
  J9.topLeftCorner<3, 3>() = -Jl_inverse * exp_x.inverse().matrix();
  result.J_measurement = W.lazyProduct(J9);
  return result;
}

bool ImuFactor::Evaluate(double const* const* parameters,
                         double* residuals,
                         double** jacobians) const {
  const Point at = point_from_blocks(parameters);
  Eigen::Map<Vector9> r(residuals);
  if (jacobians == nullptr) {
    r = residual(at);
    return r.allFinite();
  }
  const bool of_globals =
      jacobians[5] != nullptr || jacobians[6] != nullptr || jacobians[7] != nullptr;
  const Linearization linear = linearize(at, of_globals);
  r = linear.residual;
  using Block3 = Eigen::Map<Eigen::Matrix<double, 9, 3, Eigen::RowMajor>>;
  using Block6 = Eigen::Map<Eigen::Matrix<double, 9, 6, Eigen::RowMajor>>;
  using Block9 = Eigen::Map<Eigen::Matrix<double, 9, 9, Eigen::RowMajor>>;
  if (jacobians[0] != nullptr) pose_jacobian_to_block(linear.J_pose0, parameters[0], jacobians[0]);
  if (jacobians[1] != nullptr) Block3(jacobians[1], 9, 3) = linear.J_v0;
  if (jacobians[2] != nullptr) pose_jacobian_to_block(linear.J_pose1, parameters[2], jacobians[2]);
  if (jacobians[3] != nullptr) Block3(jacobians[3], 9, 3) = linear.J_v1;
  if (jacobians[4] != nullptr) Block6(jacobians[4], 9, 6) = linear.J_bias;
  if (jacobians[5] != nullptr) Block3(jacobians[5], 9, 3) = linear.J_gravity_direction;
  if (jacobians[6] != nullptr) Eigen::Map<Vector9>(jacobians[6], 9) = linear.J_time_offset;
  if (jacobians[7] != nullptr) Block9(jacobians[7], 9, 9) = linear.J_gyro_shape;
  return r.allFinite();
}

}  // namespace imslam::pgo
