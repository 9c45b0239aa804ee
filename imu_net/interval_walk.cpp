#include "imu_net/interval_walk.hpp"

#include <cmath>
#include <utility>

#include "imu_net/sample_health.hpp"

namespace imslam::imu {
namespace {

constexpr double kHolePeriods = 1.5;  ///< jitter of the stamps is no hole yet

}  // namespace

IntervalWalk::IntervalWalk(ImuRange samples,
                           ImuMotion frame,
                           const ImuNoise& noise,
                           const PreintegrationOptions& options,
                           PreintegrationRecord* record)
    : samples_(samples),
      frame_(std::move(frame)),
      noise_(noise),
      options_(options),
      start_s_(frame_.time_offset_s),
      end_s_(frame_.time_offset_s + frame_.dt_s),
      record_(record),
      integrator_(frame_.bias, noise, record != nullptr ? &record->steps : nullptr) {}

SignalNode IntervalWalk::node(const ImuSample& sample) const {
  SignalNode result;
  result.time_s = seconds(sample);
  result.rate = sample.angular_velocity;
  result.force = sample.linear_acceleration;
  result.gyro_variance = sample.gyro_variance;
  result.accel_variance = sample.accel_variance;
  return result;
}

/// The last usable sample at or before the start, or the first one of all.
const ImuSample* IntervalWalk::first_sample() const {
  const auto start_ns = frame_.time0_ns + static_cast<std::int64_t>(std::floor(start_s_ * 1e9));
  const ImuSample* sample = samples_.after(start_ns);
  while (sample != samples_.begin()) {
    --sample;
    if (start_s_ - seconds(*sample) > options_.max_bridge_s) return sample;
    if (sample_health(*sample, noise_) == SampleHealth::kGood) return sample;
  }
  return sample;
}

ImuMotion IntervalWalk::run() {
  for (const ImuSample* s = first_sample(); s != samples_.end(); ++s) {
    visit(*s);
    if (lost_ || (last_ && last_->time_s >= end_s_)) break;
    if (seconds(*s) - end_s_ > options_.max_bridge_s) break;
  }
  if (last_ && !lost_ && last_->time_s < end_s_) {  // nothing usable after the end: hold
    SignalNode from = *last_;
    if (from.time_s <= start_s_) {
      from.time_s = start_s_;
      from.time_slope = 1.0;
    }
    SignalNode to = *last_;
    to.time_s = end_s_;
    to.time_slope = 1.0;
    stretch(from, to, {last_sample_, nullptr, end_s_ - last_->time_s, saturated_});
  }
  ImuMotion motion = frame_;
  if (!last_ || lost_) return motion;
  motion = integrator_.motion();
  motion.time0_ns = frame_.time0_ns;
  motion.time1_ns = frame_.time1_ns;
  motion.dt_s = frame_.dt_s;
  motion.time_offset_s = frame_.time_offset_s;
  motion.degraded = degraded_;
  motion.valid = true;
  return motion;
}

void IntervalWalk::visit(const ImuSample& sample) {
  const SampleHealth state = sample_health(sample, noise_);
  if (state != SampleHealth::kGood) {
    dropped_ = true;
    saturated_ = saturated_ || state == SampleHealth::kSaturated;
    return;
  }
  const SignalNode current = node(sample);
  if (last_ && current.time_s <= last_->time_s) return;  // repeated or unordered stamp
  if (!last_ && current.time_s > start_s_) {             // nothing usable before the start: hold
    SignalNode from = current;
    from.time_s = start_s_;
    from.time_slope = 1.0;
    SignalNode to = current;
    if (to.time_s >= end_s_) {
      to.time_s = end_s_;
      to.time_slope = 1.0;
    }
    stretch(from, to, {nullptr, &sample, current.time_s - start_s_, saturated_});
  } else if (last_ && current.time_s > start_s_) {
    const double length_s = current.time_s - last_->time_s;
    const auto end_node = [&](double time_s) {
      SignalNode end = between(*last_, current, (time_s - last_->time_s) / length_s);
      end.time_s = time_s;
      end.time_slope = 1.0;
      end.rate_slope = (current.rate - last_->rate) / length_s;
      end.force_slope = (current.force - last_->force) / length_s;
      return end;
    };
    const SignalNode from = last_->time_s <= start_s_ ? end_node(start_s_) : *last_;
    const SignalNode to = current.time_s >= end_s_ ? end_node(end_s_) : current;
    stretch(from, to, {last_sample_, &sample, length_s, saturated_});
  }
  last_ = current;
  last_sample_ = &sample;
  dropped_ = saturated_ = false;
}

/// From a to b: between two usable samples, or a part of that.
void IntervalWalk::stretch(const SignalNode& a, const SignalNode& b, const Gap& gap) {
  if (gap.length_s > options_.max_bridge_s) {
    lost_ = true;
    return;
  }
  const bool hole = dropped_ || gap.length_s * noise_.rate_hz > kHolePeriods;
  if (!hole) {
    integrator_.add(a, b, options_.max_step_s);
    return note_sources(gap);
  }
  degraded_ = degraded_ || gap.saturated || gap.length_s > options_.max_gap_s;
  integrator_.add_gap(a, b, options_.max_step_s,
                      gap_spread(gap, frame_.dt_s, samples_, frame_.bias, noise_, options_));
  note_sources(gap);
}

/// Says of which samples the steps just recorded are made.
void IntervalWalk::note_sources(const Gap& gap) {
  if (record_ == nullptr) return;
  for (std::size_t i = record_->sources.size(); i < record_->steps.size(); ++i) {
    StepSource source;
    source.before = gap.before != nullptr ? gap.before : gap.after;
    source.after = gap.after != nullptr ? gap.after : gap.before;
    if (source.before != source.after) {
      source.share_after = (record_->steps[i].middle_s - seconds(*source.before)) / gap.length_s;
    }
    record_->sources.push_back(source);
  }
}

}  // namespace imslam::imu
