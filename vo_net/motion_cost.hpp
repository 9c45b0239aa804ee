#pragma once

#include <Eigen/Core>
#include <functional>

#include "slam/sensors/motion.hpp"
#include "vo_net/match_replay.hpp"
#include "vo_net/pose_layer.hpp"

namespace imslam::vo {

/// An upper cost U of one measured motion, and its slopes.
struct MotionSlope {
  double cost = 0.0;
  Eigen::Matrix<double, 6, 1> by_motion;      ///< right perturbation [rho theta]
  Eigen::Matrix<double, 6, 6> by_covariance;  ///< dU = trace(by_covariance^T dSigma)
};
using MotionCost = std::function<MotionSlope(const RelativeMotion&)>;

/// How the odometry made a motion of its matches; the same again on a tape.
struct MotionRecipe {
  StereoCamera camera;
  PoseLayerOptions pose;
  double sigma_floor = 0.05;   ///< [px] see make_correspondence()
  double shared_error = 0.15;  ///< see VoOptions
  lie::SE3d start;             ///< T_body0_body1 near the solution
  double disparity_offset = 0.0;
  std::int64_t time0_ns = 0;
  std::int64_t time1_ns = 0;
};

/// U of the motion that the replayed matches give:
///
///   answers --> correspondences --> solve_pose() --> T, Sigma_pose --> U(T, F Sigma_pose F)
///
/// Backward: dU/dT through the pose layer by the implicit function theorem to displacement, scale,
/// correlation and confidence of every answer; dU/dSigma to the factors F. That Sigma_pose itself
/// depends on the answers is not followed.
///
/// `noise` [1,2]: log factors of translation and rotation (MotionNoise), or none. `solved` is set
/// to the pose that was found. A motion that cannot be found, or that has no derivative, costs 0
/// and is constant: `usable` is false.
template <typename S>
struct ReplayedMotion {
  nn::Var cost;
  bool usable = false;
  PoseLayerResult pose;
  Correspondences correspondences;
};

template <typename S>
ReplayedMotion<S> motion_cost(nn::Tape<S>& tape,
                              const ReplayedMatch& match,
                              const Correspondences& recorded,
                              const MotionRecipe& recipe,
                              nn::Var noise,
                              const MotionCost& cost);

/// U(T, F Sigma F) of a motion that does not learn, only its covariance does. `noise` [1,2].
template <typename S>
nn::Var noise_cost(nn::Tape<S>& tape,
                   const RelativeMotion& motion,
                   nn::Var noise,
                   const MotionCost& cost);

}  // namespace imslam::vo
