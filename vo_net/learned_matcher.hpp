#pragma once

#include <memory>
#include <vector>

#include "slam/sensors/calibration.hpp"
#include "vo_net/learned_options.hpp"
#include "vo_net/match_network.hpp"
#include "vo_net/matcher.hpp"

namespace imslam::vo {

/// Points found again by the matching network, from frame to frame and from left to right.
///
///   corners (and centres of cells without any) in the cells that no point occupies
///   network: displacement, 2x2 covariance, confidence of every point; the predicted motion only
///       says where to search
///   Lucas-Kanade at full size from the network's answer where that is precise enough. What it
///       finds nearby replaces the answer, with the covariance of its texture and residual
///   for displacements over time where full size does not help, the same at half or quarter size,
///       where blur and noise are that much less: the network's own answers are a little short
///
/// The network sees shrunken images as long as Lucas-Kanade can go on from its answers, and whole
/// ones from the next frame on where it seldom can: in blur, noise and darkness.
/// A match whose surroundings show nothing in either image is none, whatever the network says.
class LearnedMatcher final : public Matcher {
 public:
  /// The network is for inference only, see MatchNetwork::fold(); it may be shared.
  LearnedMatcher(const LearnedMatcherOptions& options,
                 const StereoCamera& camera,
                 std::shared_ptr<MatchNetwork<float>> network);
  ~LearnedMatcher() override;

  MatchResult match(const StereoFrame& frame, const lie::SE3d& T_body0_body1_predicted) override;
  void drop(const std::vector<std::int64_t>& track_ids) override;
  void forget_newest() override;
  void reset() override;

 private:
  class State;
  std::unique_ptr<State> state_;
};

}  // namespace imslam::vo
