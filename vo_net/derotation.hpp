#pragma once

#include "slam/nn/tape.hpp"

namespace imslam::vo {

// Operations of the pose head on flow fields in units of the focal length, see FlowGrid.
// theta [N,3]: rotation vectors of R_left0_left1, N samples.

/// The flow that is left when the camera's rotation is taken out of it; needs no depth.
///
///   y = proj(R [x + flow, 1]) - x       R = Exp(theta)     proj(g) = (g_x / g_z, g_y / g_z)
///
///   backward   dg = [dy / g_z,  -(dy . proj g) / g_z]      dflow = (R^T dg)_xy
///              dtheta = J_r(theta)^T (p x R^T dg)  with p = [x + flow, 1]
///
/// flow [N,H,W,2]    place x [N,H,W,2] and confidence [N,H,W,1] are constants; y [N,H,W,2] is 0
/// where confidence is 0 or the ray turns out of view.
template <typename S>
nn::Var derotate(nn::Tape<S>& tape, nn::Var flow, nn::Var place, nn::Var confidence, nn::Var theta);

/// Log(Exp(second) Exp(first)), sample by sample.
///
///   backward   dfirst = (J_r^-1(y) J_r(first))^T dy     dsecond = (J_r^-1(y) R_first^T
///   J_r(second))^T dy
template <typename S>
nn::Var compose_rotations(nn::Tape<S>& tape, nn::Var first, nn::Var second);

/// Median of sqrt(|flow|^2 + 1e-12) over the cells with confidence; 1e-6 if there are none.
/// Its gradient goes to the median cell.      flow [N,H,W,2]    y [N,1,1,1]
template <typename S>
nn::Var median_length(nn::Tape<S>& tape, nn::Var flow, nn::Var confidence);

}  // namespace imslam::vo
