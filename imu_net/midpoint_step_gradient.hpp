#pragma once

#include <Eigen/Core>

#include "imu_net/midpoint_step.hpp"
#include "imu_net/symmetric_blocks.hpp"

namespace imslam::imu {

/// dL/d(dR, dv, dp, Sigma) at one end of a step.
struct StateGradient {
  Eigen::Vector3d R = Eigen::Vector3d::Zero();  ///< by theta of dR Exp(theta)
  Eigen::Vector3d v = Eigen::Vector3d::Zero();
  Eigen::Vector3d p = Eigen::Vector3d::Zero();
  SymmetricBlocks Sigma;  ///< dL = sum over all 81 entries of Sigma(i, j) dSigma(i, j)
};

/// dL/d(StepInput); its length is given.
struct StepGradient {
  Eigen::Vector3d rate, force, rate_variance, force_variance;
};

/// Turns dL/d(state after the step) into dL/d(state before it) and returns what its input adds.
/// A_Sigma_R is what MidpointStep::carry_covariance() returned.
///
///   G = dL/dSigma':   dL/dA = 2 G A Sigma,  dL/dB = 2 G B Q,  dL/dQ_kk = (B^T G B)_kk,
///                     dL/dSigma = A^T G A
StepGradient pull_back(const MidpointStep& step,
                       const Eigen::Matrix<double, 9, 3>& A_Sigma_R,
                       StateGradient& gradient);

}  // namespace imslam::imu
