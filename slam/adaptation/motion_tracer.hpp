#pragma once

#include <deque>
#include <memory>
#include <vector>

#include "slam/sensors/calibration.hpp"
#include "slam/sensors/stereo.hpp"
#include "vo_net/visual_odometry.hpp"

namespace imslam::adaptation {

/// All that the front end had and did when it measured one motion: enough to do it again on a tape.
struct MotionTrace {
  std::shared_ptr<const StereoFrame> before;
  std::shared_ptr<const StereoFrame> now;
  vo::Correspondences correspondences;
  vo::MatchSearch search;
  vo::PoseLayerResult pose;
  vo::MotionNoiseFeatures features;
};

/// Watches a run and keeps the traces of the wanted frames, images included if need be: about 1.5
/// MB each.
class MotionTracer {
 public:
  /// `wanted`: by StereoFrame::index; longer indices are not wanted. Without `images` the frames of
  /// the traces are only stamps.
  MotionTracer(std::vector<bool> wanted, const StereoCamera& camera, bool images);

  void see(const StereoFrame& frame, const vo::VoOutput& seen);

  /// In order of time; frames without a motion left no trace.
  std::vector<MotionTrace>& traces() { return traces_; }

 private:
  std::shared_ptr<const StereoFrame> copy_of(const StereoFrame& frame) const;
  /// The frame a motion began at, if it is still known; motions seldom span more than a few.
  std::shared_ptr<const StereoFrame> recent(std::int64_t time_ns) const;

  std::vector<bool> wanted_;
  StereoCamera camera_;
  bool images_;
  std::deque<std::shared_ptr<const StereoFrame>> recent_;
  int shrink_before_ = 0;
  std::vector<MotionTrace> traces_;
};

}  // namespace imslam::adaptation
