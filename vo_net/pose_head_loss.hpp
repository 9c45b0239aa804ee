#pragma once

#include <vector>

#include "vo_net/pose_head.hpp"

namespace imslam::vo {

/// The true motion of N samples.
template <typename S>
struct PoseHeadTruth {
  nn::Tensor<S> rotation;   ///< [N,3] rotation vector of R_left0_left1 [rad]
  nn::Tensor<S> direction;  ///< [N,3] of p_left0_left1, of length 1; any where it stands still
  nn::Tensor<S> moves;      ///< [N,1] 1, or 0: stands still, the direction means nothing
};

/// Negative log-likelihood of the truth, mean over the samples; earlier looks count less.
///
///   sum over looks k of w_k (sum_i t(theta_i - theta*_i; s_i) + moves n(d - d*; s_d))
///
///   t   Student t, nu = 4, see nn::student_t_nll
///   n   the same in the two dimensions across the direction, from the chord:
///       2 s_d + (nu + 2)/2 log(1 + |d - d*|^2 e^{-2 s_d} / nu)
///   w   1 for the last look, `early_weight` for the ones before
template <typename S>
nn::Var pose_head_loss(nn::Tape<S>& tape,
                       const std::vector<PoseHeadOutput>& looks,
                       const PoseHeadTruth<S>& truth,
                       double early_weight);

}  // namespace imslam::vo
