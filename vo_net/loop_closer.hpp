#pragma once

#include <optional>
#include <vector>

#include "slam/sensors/motion.hpp"
#include "slam/sensors/stereo.hpp"
#include "vo_net/keyframe_map.hpp"
#include "vo_net/keyframe_match.hpp"

namespace imslam::vo {

/// Ties the present to old views: motions from frames of long ago, measured afresh, whose errors
/// are not those of the odometry.
///
/// Holds its own estimate of where the body is in the map of its keyframes, the odometry corrected
/// by what it recognises. How sure it is of the motion since a view is known view by view: what
/// both have in common of the odometry's error does not count, and a view that is seen again and
/// again says nothing of the others. It only says where to search and which views to compare; the
/// motions do not lean on it.
class LoopCloser {
 public:
  /// `load` is asked for the images of frames that come unread, if there are any.
  LoopCloser(const LoopOptions& options,
             const VoOptions& vo,
             const StereoCamera& camera,
             FrameLoader load = {});

  /// A frame and what the odometry made of it, in order of time. Returns motions from old frames to
  /// this one, none for most frames.
  std::vector<RelativeMotion> process(const StereoFrame& frame,
                                      const VoOutput& seen,
                                      double disparity_offset);

  const KeyframeMap& map() const { return map_; }
  lie::SE3d T_map_body() const { return T_map_body_; }

 private:
  using Matrix6 = Eigen::Matrix<double, 6, 6>;
  void advance(const RelativeMotion& motion);
  void bridge(std::int64_t time_ns);
  void move(const lie::SE3d& T_body0_body1, const Matrix6& covariance);
  const StereoFrame& with_images(const StereoFrame& frame);
  std::vector<RelativeMotion> recognise(const StereoFrame& frame, double disparity_offset);
  std::optional<PredictedMotion> predict(const Keyframe& keyframe);
  Matrix6 covariance_by_last_match(const Keyframe& keyframe, const lie::SE3d& T_body0_body1);
  double search_px(const Keyframe& keyframe, const Matrix6& covariance) const;
  void correct(std::int64_t keyframe_ns, const RelativeMotion& motion);
  void keep(const StereoFrame& frame, const std::vector<StereoPoint>& points);

  LoopOptions options_;
  VoOptions vo_;
  StereoCamera camera_;
  KeyframeMap map_;
  KeyframeMatcher matcher_;
  CurrentView view_;
  FrameLoader load_;
  StereoFrame loaded_;  ///< the last one that came unread
  lie::SE3d T_map_body_;
  Drift drift_;
  std::optional<std::int64_t> time_ns_;     ///< of T_map_body_
  std::optional<std::int64_t> matched_ns_;  ///< the view that was recognised last
  std::int64_t corrected_ns_ = 0;           ///< when that was: T_map_body_ made a jump
  int frames_since_search_ = 0;
};

}  // namespace imslam::vo
