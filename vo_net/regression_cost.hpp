#pragma once

#include "vo_net/motion_cost.hpp"
#include "vo_net/pose_head.hpp"
#include "vo_net/regression_odometry.hpp"

namespace imslam::vo {

/// U of the motion that a pose head regresses from matches:
///
///   grid --> looks --> theta, d, sigmas --correct_scale--> s --> T, Sigma --> U(T, F Sigma F)
///
/// Backward: dU/dT to theta and d, the scale's dependence on both included; dU/dSigma to the log
/// sigmas and to F. That Sigma depends on theta, d and s is not followed. `noise`: see
/// motion_cost().
struct RegressedMotion {
  nn::Var cost;
  std::vector<PoseHeadOutput> looks;
  bool usable = false;  ///< false: no scale, or no motion; costs 0 and is constant
};

template <typename S>
RegressedMotion regression_cost(nn::Tape<S>& tape,
                                const PoseHead<S>& network,
                                const Correspondences& correspondences,
                                const MotionRecipe& recipe,
                                const ScaleOptions& options,
                                nn::Var noise,
                                const MotionCost& cost);

}  // namespace imslam::vo
