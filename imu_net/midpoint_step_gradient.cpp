#include "imu_net/midpoint_step_gradient.hpp"

namespace imslam::imu {

using Eigen::Matrix3d;
using Eigen::Vector3d;
using lie::axial;
using lie::SO3d;

namespace {

/// Velocity and position get the same B and A_v, the latter h/2 times: together they are a
/// coordinate s with G_s = G_v + h/2 G_p.
struct HalvedBlocks {
  Matrix3d sR, sv, sp, ss;

  HalvedBlocks(const SymmetricBlocks& G, double h)
      : sR(G.vR + 0.5 * h * G.pR),
        sv(G.vv + 0.5 * h * G.pv),
        sp(G.pv.transpose() + 0.5 * h * G.pp),
        ss(sv + 0.5 * h * sp) {}
};

/// dL/dA_R and dL/dA_v.
struct TransitionGradient {
  Matrix3d A_R, A_v;

  TransitionGradient(const SymmetricBlocks& G,
                     const HalvedBlocks& H,
                     const Eigen::Matrix<double, 9, 3>& A_Sigma_R) {
    const Matrix3d R = 2.0 * A_Sigma_R.topRows<3>();
    const Matrix3d v = 2.0 * A_Sigma_R.middleRows<3>(3);
    const Matrix3d p = 2.0 * A_Sigma_R.bottomRows<3>();
    A_R = G.RR * R + G.vR.transpose() * v + G.pR.transpose() * p;
    A_v = H.sR * R + H.sv * v + H.sp * p;
  }
};

/// By B_rate: dL/dJ_full, dL/dJ_half and dL/dQ_rate.
struct RateNoiseGradient {
  Matrix3d J_full, J_half;
  Vector3d variance;

  RateNoiseGradient(const MidpointStep& step, const SymmetricBlocks& G, const HalvedBlocks& H) {
    const double h = step.in.h;
    const Matrix3d GB_R = h * (G.RR * step.J_full) + h * h * (H.sR.transpose() * step.J_half);
    const Matrix3d GB_s = h * (H.sR * step.J_full) + h * h * (H.ss * step.J_half);
    J_full = 2.0 * h * GB_R * step.in.rate_variance.asDiagonal();
    J_half = 2.0 * h * h * GB_s * step.in.rate_variance.asDiagonal();
    variance = h * step.J_full.cwiseProduct(GB_R).colwise().sum().transpose() +
               h * h * step.J_half.cwiseProduct(GB_s).colwise().sum().transpose();
  }
};

/// A^T G A.
void pull_back_covariance(const MidpointStep& step, const HalvedBlocks& H, SymmetricBlocks& G) {
  const double h = step.in.h;
  const Matrix3d GA_R = G.RR * step.A_R + H.sR.transpose() * step.A_v;
  const Matrix3d GA_v = G.vR * step.A_R + H.sv.transpose() * step.A_v;
  const Matrix3d GA_p = G.pR * step.A_R + H.sp.transpose() * step.A_v;
  const Matrix3d GA_s = GA_v + 0.5 * h * GA_p;
  G.RR = step.A_R.transpose() * GA_R + step.A_v.transpose() * GA_s;
  G.vR = GA_v + h * GA_p;
  G.pR = GA_p;
  G.vv += h * (G.pv + G.pv.transpose()) + h * h * G.pp;
  G.pv += h * G.pp;
}

}  // namespace

StepGradient pull_back(const MidpointStep& step,
                       const Eigen::Matrix<double, 9, 3>& A_Sigma_R,
                       StateGradient& gradient) {
  const double h = step.in.h;
  const Vector3d& f = step.in.force;
  SymmetricBlocks& G = gradient.Sigma;
  const HalvedBlocks H(G, h);
  const TransitionGradient dA(G, H, A_Sigma_R);
  const RateNoiseGradient dB(step, G, H);
  // White noise of the force enters as M Q M^T only.
  const Matrix3d d_noise = h * h * (H.ss + h * h / 12.0 * G.pp);
  const Matrix3d MtNM = step.M.transpose() * d_noise * step.M;

  // M^T dL/dF, where F = -M [f]x is in A_v = h F E^T and in J_half = F Jr(w/2) / 2.
  const Matrix3d dF_transition = h * (step.M.transpose() * dA.A_v * step.E);
  const Matrix3d dF_noise = 0.5 * (step.M.transpose() * dB.J_half);
  const Matrix3d dF = dF_transition + dF_noise * step.Jr_half.transpose();
  const Vector3d d_velocity = step.M.transpose() * (h * gradient.v + 0.5 * h * h * gradient.p);

  // By rotations on the right of M, of E (which is in M), and of dR'.
  const Vector3d d_M = dF.trace() * f - dF.transpose() * f + f.cross(d_velocity) +
                       axial(2.0 * MtNM * step.in.force_variance.asDiagonal());
  const Vector3d d_E = d_M - dF_transition.trace() * f + dF_transition * f;
  const Vector3d d_end = gradient.R + axial(step.A_R * dA.A_R.transpose());
  const Matrix3d d_Jr_half = lie::skew(f) * dF_noise;

  StepGradient result;
  result.rate = h * (step.J_full.transpose() * d_end + 0.5 * step.Jr_half.transpose() * d_E +
                     SO3d::right_jacobian_gradient(h * step.in.rate, dB.J_full) +
                     0.5 * SO3d::right_jacobian_gradient(0.5 * h * step.in.rate, d_Jr_half));
  result.force = d_velocity - axial(dF);
  result.rate_variance = dB.variance;
  result.force_variance = MtNM.diagonal();

  gradient.R = step.A_R.transpose() * gradient.R + step.E * d_M;
  gradient.v += h * gradient.p;
  pull_back_covariance(step, H, G);
  return result;
}

}  // namespace imslam::imu
