#pragma once

#include <cstddef>
#include <optional>

#include "datasets/frame_reader.hpp"
#include "datasets/sequence.hpp"
#include "slam/sensors/stereo.hpp"
#include "vo_net/match_recording.hpp"

namespace imslam::system {

/// The frames [first, last) of a sequence, in order: decoded ahead, or, where a recording has what
/// a matcher said of them, unread.
class FrameSource {
 public:
  /// `matches` null: there is no recording.
  FrameSource(datasets::Sequence& sequence,
              std::size_t first,
              std::size_t last,
              const vo::MatchRecording* matches);

  /// Empty after the last one. Throws what reading the sequence throws.
  std::optional<StereoFrame> next();

  /// For frames that came unread.
  FrameLoader loader();

 private:
  datasets::Sequence& sequence_;
  std::size_t next_;
  std::size_t last_;
  const vo::MatchRecording* matches_;
  std::optional<datasets::FrameReader> reader_;  ///< empty: nothing is decoded
};

}  // namespace imslam::system
