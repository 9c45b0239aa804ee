#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <vector>

#include "slam/lie/se3.hpp"
#include "slam/sensors/stereo.hpp"
#include "vo_net/correspondence.hpp"

namespace imslam::vo {

/// A point seen by one stereo pair.
struct StereoPoint {
  Eigen::Vector2d left = Eigen::Vector2d::Zero();  ///< [px]
  double disparity = 0.0;                          ///< [px]
  double disparity_information = 1.0;              ///< [1/px^2]
  double row_error = 0.0;  ///< [px] v_right - v_left, a check on rectification
  std::int64_t track_id = -1;
};

/// Where and how finely a network searched: with its images all that its answers depend on.
struct MatchSearch {
  Eigen::Vector2d predicted = Eigen::Vector2d::Zero();  ///< [px] displacement it was centred on
  int shrink = 1;                                       ///< [px] of the image per pixel it saw
};

/// Correspondences between the frame taken at time0_ns and the newest one.
struct FrameMatch {
  std::int64_t time0_ns = 0;
  Correspondences correspondences;
  MatchSearch search;  ///< of the learned matcher
};

/// What a matcher finds in a new frame.
struct MatchResult {
  FrameMatch previous;              ///< with the frame before; empty in the first frame
  std::vector<FrameMatch> earlier;  ///< with older frames, for skip edges
  std::vector<StereoPoint> points;  ///< all that is seen in this frame, depth included
};

/// Finds the same points in successive stereo pairs. Implementations keep what they need of the
/// frames before. Equal input gives equal output, whatever the thread count.
class Matcher {
 public:
  virtual ~Matcher() = default;

  /// `frame` must be complete and of one size throughout; frames come in order of time, but some
  /// may have been left out. `T_body0_body1_predicted` (previous frame given, to this one) only
  /// says where to begin to search.
  virtual MatchResult match(const StereoFrame& frame, const lie::SE3d& T_body0_body1_predicted) = 0;

  /// Tells that these tracks contradict the motion that was found: they are not followed further.
  virtual void drop(const std::vector<std::int64_t>& track_ids) = 0;

  /// As though the newest frame had never come: the next one is matched with the frame before it.
  /// For frames that turned out useless. Once per match().
  virtual void forget_newest() = 0;

  /// Forgets all frames, e.g. after a cut.
  virtual void reset() = 0;
};

}  // namespace imslam::vo
