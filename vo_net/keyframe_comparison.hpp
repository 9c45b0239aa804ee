#pragma once

#include <optional>
#include <vector>

#include "vo_net/keyframe_match.hpp"
#include "vo_net/pose_layer.hpp"
#include "vo_net/warped_patch.hpp"

namespace imslam::vo {

/// A keyframe's point and where a motion takes it.
struct KeyframeTarget {
  const StereoPoint* point = nullptr;
  PatchWarp warp;
  double disparity = 0.0;  ///< [px] expected
};

/// One comparison of a keyframe with a frame. What it is given must outlive it.
class KeyframeComparison {
 public:
  KeyframeComparison(const LoopOptions& options,
                     const VoOptions& vo,
                     const StereoCamera& camera,
                     const Keyframe& keyframe,
                     const CurrentView& view,
                     double disparity_offset);

  /// Points that a motion brings into the image.
  std::vector<KeyframeTarget> targets(const lie::SE3d& T_body0_body1) const;

  /// A first motion from a wide search; empty if the points found do not agree.
  std::optional<lie::SE3d> scout(const PredictedMotion& predicted) const;

  /// The final motion.
  std::optional<PoseLayerResult> measure(const lie::SE3d& T_body0_body1) const;

 private:
  std::optional<KeyframeTarget> target(const StereoPoint& point,
                                       const lie::SE3d& T_left1_left0) const;
  std::optional<Correspondence> search(const KeyframeTarget& target, double radius) const;
  std::optional<Correspondence> refine(const KeyframeTarget& target) const;
  bool well_spread(const Correspondences& matches, const PoseLayerResult& pose) const;

  const LoopOptions& options_;
  const VoOptions& vo_;
  const StereoCamera& camera_;
  const Keyframe& keyframe_;
  const CurrentView& view_;
  double offset_;
  ImagePyramid then_;
  AlignOptions align_;
};

}  // namespace imslam::vo
