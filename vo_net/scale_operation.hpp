#pragma once

#include "slam/nn/tape.hpp"
#include "vo_net/scale_corrector.hpp"

namespace imslam::vo {

/// correct_scale() on the tape: the metric translation behind a pose head's answer for one sample.
///
///   p = s d,   s = correct_scale(matches, theta, d).scale
///
///   backward   ds = dp . d      dd = s dp + J_direction ds     dtheta = J_r(theta)^T J_rotation ds
///              dmeasured = ds * scale_gradient
///
/// rotation [1,3]    direction [1,3]    y [1,3] [m]
/// measured [P,3], rows [u_left1 v_left1 disparity0] that replace those numbers of the P
/// correspondences, or none. Where the scale has no derivative nothing goes back through it.
template <typename S>
nn::Var metric_translation(nn::Tape<S>& tape,
                           nn::Var rotation,
                           nn::Var direction,
                           nn::Var measured,
                           const Correspondences& correspondences,
                           const StereoCamera& camera,
                           const ScaleOptions& options);

}  // namespace imslam::vo
