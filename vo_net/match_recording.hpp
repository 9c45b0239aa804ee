#pragma once

#include <cstdint>
#include <map>
#include <memory>

#include "vo_net/matcher.hpp"

namespace imslam::vo {

/// The answers of a matcher over a sequence, by the stamps of the frames: 0.1 to 0.2 MB each.
///
/// As long as neither its network nor the images change, asking it anew gives the same matches but
/// for where it was told to begin to search and which tracks it was told to drop.
class MatchRecording {
 public:
  void add(std::int64_t time_ns, const MatchResult& answer) { answers_[time_ns] = answer; }
  /// Null: no such frame.
  const MatchResult* find(std::int64_t time_ns) const;
  std::size_t size() const { return answers_.size(); }

 private:
  std::map<std::int64_t, MatchResult> answers_;
};

/// A matcher whose answers are taken down.
class RecordingMatcher final : public Matcher {
 public:
  RecordingMatcher(std::unique_ptr<Matcher> matcher, std::shared_ptr<MatchRecording> recording);

  MatchResult match(const StereoFrame& frame, const lie::SE3d& T_body0_body1_predicted) override;
  void drop(const std::vector<std::int64_t>& track_ids) override { matcher_->drop(track_ids); }
  void forget_newest() override { matcher_->forget_newest(); }
  void reset() override { matcher_->reset(); }

 private:
  std::unique_ptr<Matcher> matcher_;
  std::shared_ptr<MatchRecording> recording_;
};

/// Gives the answers of a recording again; looks at no pixel. Where the frames that count are no
/// longer those of the recording (another one was forgotten), a frame has points but no matches.
class ReplayingMatcher final : public Matcher {
 public:
  explicit ReplayingMatcher(std::shared_ptr<const MatchRecording> recording);

  /// ContractError if the recording lacks the frame.
  MatchResult match(const StereoFrame& frame, const lie::SE3d& T_body0_body1_predicted) override;
  void drop(const std::vector<std::int64_t>&) override {}
  void forget_newest() override { newest_ns_ = before_ns_; }
  void reset() override { newest_ns_ = before_ns_ = kNone; }

 private:
  static constexpr std::int64_t kNone = INT64_MIN;

  std::shared_ptr<const MatchRecording> recording_;
  std::int64_t newest_ns_ = kNone;  ///< of the last frame that counts
  std::int64_t before_ns_ = kNone;  ///< of the one before it
};

}  // namespace imslam::vo
