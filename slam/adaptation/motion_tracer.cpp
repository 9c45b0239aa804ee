#include "slam/adaptation/motion_tracer.hpp"

#include <utility>

namespace imslam::adaptation {
namespace {

constexpr std::size_t kRecent = 3;  // [frames]

}  // namespace

MotionTracer::MotionTracer(std::vector<bool> wanted, const StereoCamera& camera, bool images)
    : wanted_(std::move(wanted)), camera_(camera), images_(images) {}

std::shared_ptr<const StereoFrame> MotionTracer::copy_of(const StereoFrame& frame) const {
  if (images_) return std::make_shared<const StereoFrame>(frame);
  StereoFrame stamp;
  stamp.index = frame.index;
  stamp.time_ns = frame.time_ns;
  return std::make_shared<const StereoFrame>(std::move(stamp));
}

std::shared_ptr<const StereoFrame> MotionTracer::recent(std::int64_t time_ns) const {
  for (const auto& frame : recent_) {
    if (frame->time_ns == time_ns) return frame;
  }
  return nullptr;
}

void MotionTracer::see(const StereoFrame& frame, const vo::VoOutput& seen) {
  const auto is_wanted = [&](std::size_t index) {
    return index < wanted_.size() && wanted_[index];
  };
  const bool soon =
      is_wanted(frame.index) || is_wanted(frame.index + 1) || is_wanted(frame.index + 2);
  const auto now = soon ? copy_of(frame) : nullptr;
  const int shrink_before = std::exchange(shrink_before_, seen.search.shrink);
  if (is_wanted(frame.index) && seen.motion.valid) {
    MotionTrace trace;
    trace.before = recent(seen.motion.time0_ns);
    trace.now = now;
    trace.correspondences = seen.correspondences;
    trace.search = seen.search;
    trace.pose = seen.pose;
    trace.features = vo::motion_noise_features(seen.pose, seen.correspondences, camera_);
    if (shrink_before != seen.search.shrink) {
      // The first pair was looked at in another size: those answers cannot be had again.
      for (vo::Correspondence& c : trace.correspondences) c.learned.disparity0 = false;
    }
    if (trace.before) traces_.push_back(std::move(trace));
  }
  if (!now) return;
  recent_.push_back(now);
  if (recent_.size() > kRecent) recent_.pop_front();
}

}  // namespace imslam::adaptation
