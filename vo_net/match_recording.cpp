#include "vo_net/match_recording.hpp"

#include <utility>

#include "slam/base/error.hpp"

namespace imslam::vo {

const MatchResult* MatchRecording::find(std::int64_t time_ns) const {
  const auto found = answers_.find(time_ns);
  return found == answers_.end() ? nullptr : &found->second;
}

RecordingMatcher::RecordingMatcher(std::unique_ptr<Matcher> matcher,
                                   std::shared_ptr<MatchRecording> recording)
    : matcher_(std::move(matcher)), recording_(std::move(recording)) {}

MatchResult RecordingMatcher::match(const StereoFrame& frame,
                                    const lie::SE3d& T_body0_body1_predicted) {
  MatchResult answer = matcher_->match(frame, T_body0_body1_predicted);
  recording_->add(frame.time_ns, answer);
  return answer;
}

ReplayingMatcher::ReplayingMatcher(std::shared_ptr<const MatchRecording> recording)
    : recording_(std::move(recording)) {}

MatchResult ReplayingMatcher::match(const StereoFrame& frame, const lie::SE3d&) {
  const MatchResult* recorded = recording_->find(frame.time_ns);
  expects(recorded != nullptr, "ReplayingMatcher: the recording has all frames");
  MatchResult answer = *recorded;
  before_ns_ = std::exchange(newest_ns_, frame.time_ns);
  if (answer.previous.time0_ns != before_ns_) answer.previous.correspondences.clear();
  return answer;
}

}  // namespace imslam::vo
