#include "slam/system/frame_source.hpp"

namespace imslam::system {

FrameSource::FrameSource(datasets::Sequence& sequence,
                         std::size_t first,
                         std::size_t last,
                         const vo::MatchRecording* matches)
    : sequence_(sequence), next_(first), last_(last), matches_(matches) {
  if (matches_ == nullptr) reader_.emplace(sequence, first, last);
}

std::optional<StereoFrame> FrameSource::next() {
  if (reader_) return reader_->next();
  if (next_ >= last_) return std::nullopt;
  StereoFrame frame;
  frame.index = next_++;
  frame.time_ns = sequence_.frame_time_ns(frame.index);
  frame.unread = matches_->find(frame.time_ns) != nullptr;  // a matcher sees complete frames only
  return frame;
}

FrameLoader FrameSource::loader() {
  return [this](std::size_t index) { return sequence_.read_frame(index); };
}

}  // namespace imslam::system
