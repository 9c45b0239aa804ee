#include "imu_net/midpoint_step.hpp"

namespace imslam::imu {

using Eigen::Matrix3d;
using lie::SO3d;

MidpointStep::MidpointStep(const StepInput& input, const SO3d& dR)
    : in(input),
      half(SO3d::exp(0.5 * in.h * in.rate)),
      middle(dR * half),
      E(half.matrix()),
      M(middle.matrix()),
      A_R((half * half).matrix().transpose()),
      J_full(SO3d::right_jacobian(in.h * in.rate)),
      Jr_half(SO3d::right_jacobian(0.5 * in.h * in.rate)) {
  const Matrix3d F = -M * lie::skew(in.force);
  A_v.noalias() = in.h * F * E.transpose();
  J_half.noalias() = 0.5 * F * Jr_half;
}

Eigen::Matrix<double, 9, 3> MidpointStep::B_rate() const {
  const double h = in.h;
  Eigen::Matrix<double, 9, 3> B;
  B << h * J_full, h * h * J_half, 0.5 * h * h * h * J_half;
  return B;
}

Eigen::Matrix<double, 9, 3> MidpointStep::B_force() const {
  Eigen::Matrix<double, 9, 3> B;
  B << Matrix3d::Zero(), in.h * M, 0.5 * in.h * in.h * M;
  return B;
}

Eigen::Matrix<double, 9, 3> MidpointStep::carry_covariance(SymmetricBlocks& Sigma) const {
  const double h = in.h;
  const double h2 = h * h;
  // U = A Sigma, its blocks on and below the diagonal.
  const Matrix3d turned_R = A_v * Sigma.RR;
  const Matrix3d turned_v = A_v * Sigma.vR.transpose();
  const Matrix3d turned_p = A_v * Sigma.pR.transpose();
  const Matrix3d U_RR = A_R * Sigma.RR;
  const Matrix3d U_vR = Sigma.vR + turned_R;
  const Matrix3d U_vv = Sigma.vv + turned_v;
  const Matrix3d U_pR = Sigma.pR + h * Sigma.vR + 0.5 * h * turned_R;
  const Matrix3d U_pv = Sigma.pv + h * Sigma.vv + 0.5 * h * turned_v;
  const Matrix3d U_pp = Sigma.pp + h * Sigma.pv.transpose() + 0.5 * h * turned_p;

  const Matrix3d J_full_Q = J_full * in.rate_variance.asDiagonal();
  const Matrix3d J_half_Q = J_half * in.rate_variance.asDiagonal();
  const Matrix3d N_vR = h * h2 * (J_half_Q * J_full.transpose());
  const Matrix3d N_half = h2 * h2 * (J_half_Q * J_half.transpose());
  const Matrix3d N_force = h2 * (M * in.force_variance.asDiagonal() * M.transpose());
  const Matrix3d N_vv = N_half + N_force;

  const Matrix3d turned = U_pR * A_v.transpose();
  Sigma.RR = U_RR * A_R.transpose() + h2 * (J_full_Q * J_full.transpose());
  Sigma.vR = U_vR * A_R.transpose() + N_vR;
  Sigma.pR = U_pR * A_R.transpose() + 0.5 * h * N_vR;
  Sigma.vv = U_vR * A_v.transpose() + U_vv + N_vv;
  Sigma.pv = turned + U_pv + 0.5 * h * N_vv;
  Sigma.pp = 0.5 * h * turned + h * U_pv + U_pp + h2 * (0.25 * N_vv + N_force / 12.0);

  Eigen::Matrix<double, 9, 3> U_R;
  U_R << U_RR, U_vR, U_pR;
  return U_R;
}

}  // namespace imslam::imu
