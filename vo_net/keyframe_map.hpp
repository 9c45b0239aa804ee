#pragma once

#include <vector>

#include "slam/sensors/calibration.hpp"
#include "vo_net/keyframe.hpp"
#include "vo_net/loop_options.hpp"

namespace imslam::vo {

/// How much of what `keyframe` saw a camera at T_map_left sees, and sees alike: share of its points
/// that lie in the image at a similar size and from a similar direction. [1]
double similarity(const Keyframe& keyframe,
                  const lie::SE3d& T_map_left,
                  const StereoCamera& camera);

/// Views of the past, spread over where the camera has been.
///
/// Bounded: where one has to go, it is the younger one of the two most similar views. The older one
/// holds more of the drift.
class KeyframeMap {
 public:
  KeyframeMap(const LoopOptions& options, const StereoCamera& camera);

  void add(Keyframe keyframe);

  /// The body has moved on: what is known of its motion since each view gets less sure.
  void move(const lie::SE3d& T_body0_body1, const Eigen::Matrix<double, 6, 6>& covariance);
  /// The view of that time, if it is still kept. Valid until the next add().
  Keyframe* at(std::int64_t time_ns);

  /// A view taken at least options.min_gap_s before `time_ns` and its similarity with the present.
  struct Candidate {
    const Keyframe* keyframe = nullptr;  ///< valid until the next add()
    double similarity = 0.0;
  };
  /// The most similar one first, then the older before the younger; at most options.max_edges.
  std::vector<Candidate> candidates(const lie::SE3d& T_map_left, std::int64_t time_ns) const;

  /// Whether no view is similar to what is seen from here.
  bool is_new_view(const lie::SE3d& T_map_left) const;

  std::size_t size() const { return entries_.size(); }
  std::size_t capacity() const;
  std::size_t bytes() const;

 private:
  struct Entry {
    Keyframe keyframe;
    std::vector<double> to_older;  ///< similarity with each entry before it
  };
  void make_room();

  LoopOptions options_;
  StereoCamera camera_;
  std::vector<Entry> entries_;  ///< in order of time
};

}  // namespace imslam::vo
