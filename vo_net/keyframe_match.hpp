#pragma once

#include <Eigen/Core>
#include <optional>

#include "slam/lie/se3.hpp"
#include "slam/sensors/calibration.hpp"
#include "vo_net/image_pyramid.hpp"
#include "vo_net/keyframe.hpp"
#include "vo_net/loop_options.hpp"
#include "vo_net/visual_odometry.hpp"

namespace imslam::vo {

/// The frame in which old views are looked for.
struct CurrentView {
  ImagePyramid left;
  ImagePyramid right;
};

/// Where the body is thought to be, seen from a keyframe's body.
struct PredictedMotion {
  lie::SE3d T_body0_body1;
  Eigen::Matrix<double, 6, 6> covariance = Eigen::Matrix<double, 6, 6>::Identity();
};

/// Finds a keyframe's points afresh in the present frame and solves for the motion between the two.
///
///   patches warped as the prediction says  ->  search as far as its uncertainty reaches  ->  a
///   first motion  ->  patches warped anew, Lucas-Kanade there and back, disparity  ->  pose layer
///
/// Stateless: equal input gives equal output for any thread count.
class KeyframeMatcher {
 public:
  /// `vo` must have passed validate().
  KeyframeMatcher(const LoopOptions& options, const VoOptions& vo, const StereoCamera& camera);

  /// The motion with its covariance; empty unless enough well spread points agree on it, near the
  /// prediction. `disparity_offset` [px] as in solve_pose().
  std::optional<RelativeMotion> match(const Keyframe& keyframe,
                                      const CurrentView& view,
                                      std::int64_t time_ns,
                                      const PredictedMotion& predicted,
                                      double disparity_offset) const;

 private:
  LoopOptions options_;
  VoOptions vo_;
  StereoCamera camera_;
};

}  // namespace imslam::vo
