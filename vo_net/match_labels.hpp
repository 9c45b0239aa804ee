#pragma once

#include "slam/sensors/calibration.hpp"
#include "vo_net/match_loss.hpp"
#include "vo_net/match_replay.hpp"
#include "vo_net/pose_layer.hpp"

namespace imslam::vo {

/// Where the points of a motion must lie if somebody else is right about the motion: what the
/// network's three answers should have been.
struct MatchLabels {
  MatchTruth<float> flow;     ///< [1,P,2] in pixels of the network
  MatchTruth<float> stereo0;  ///< [1,P,1]
  MatchTruth<float> stereo1;  ///< [1,P,1]
};

/// For each correspondence the most likely depth at the given motion, from all four of its
/// measurements; from it where the point lies in the other three images.
///
///   inliers of `pose`                   valid and visible: right answers
///   more than `wrong_px` off            valid, not visible: whatever was seen, it was not the
///   point in between                          not valid: nobody knows
///
/// `disparity_offset` [px]: of the rectification, at the given motion. shrink: of the network.
MatchLabels match_labels(const Correspondences& correspondences,
                         const PoseLayerResult& pose,
                         const StereoCamera& camera,
                         const lie::SE3d& T_body0_body1,
                         double disparity_offset,
                         int shrink,
                         double wrong_px = 4.0);

}  // namespace imslam::vo
