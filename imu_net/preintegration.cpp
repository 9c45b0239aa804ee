#include "imu_net/preintegration.hpp"

#include <algorithm>
#include <cmath>
#include <optional>

#include "imu_net/gap_model.hpp"
#include "imu_net/midpoint_integrator.hpp"
#include "imu_net/option_bounds.hpp"
#include "imu_net/sample_health.hpp"
#include "slam/base/config.hpp"
#include "slam/base/error.hpp"
#include "slam/base/time.hpp"

namespace imslam::imu {
namespace {

constexpr double kUnknownVariance = 1e6;
constexpr double kLargestOffset_s = 1e3;
constexpr double kHolePeriods = 1.5;  ///< jitter of the stamps is no hole yet

/// Walks over the usable samples around one interval and hands each stretch to the integrator.
class IntervalWalk {
 public:
  IntervalWalk(ImuRange samples,
               ImuMotion frame,
               const ImuNoise& noise,
               const PreintegrationOptions& options)
      : samples_(samples),
        frame_(std::move(frame)),
        noise_(noise),
        options_(options),
        start_s_(frame_.time_offset_s),
        end_s_(frame_.time_offset_s + frame_.dt_s),
        integrator_(frame_.bias, noise) {}

  ImuMotion run();

 private:
  double seconds(const ImuSample& sample) const {
    return to_seconds(sample.time_ns - frame_.time0_ns);
  }
  SignalNode node(const ImuSample& sample) const {
    SignalNode result;
    result.time_s = seconds(sample);
    result.rate = sample.angular_velocity;
    result.force = sample.linear_acceleration;
    result.gyro_variance = sample.gyro_variance;
    result.accel_variance = sample.accel_variance;
    return result;
  }
  const ImuSample* first_sample() const;
  void visit(const ImuSample& sample);
  void stretch(const SignalNode& a, const SignalNode& b, const Gap& gap);

  ImuRange samples_;
  ImuMotion frame_;
  const ImuNoise& noise_;
  const PreintegrationOptions& options_;
  double start_s_;
  double end_s_;
  MidpointIntegrator integrator_;
  std::optional<SignalNode> last_;  ///< the newest usable sample
  const ImuSample* last_sample_ = nullptr;
  bool dropped_ = false;    ///< a reading was refused since `last_`
  bool saturated_ = false;  ///< it was at the limit of the range
  bool degraded_ = false;
  bool lost_ = false;
};

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
  if (!hole) return integrator_.add(a, b, options_.max_step_s);
  degraded_ = degraded_ || gap.saturated || gap.length_s > options_.max_gap_s;
  integrator_.add_gap(a, b, options_.max_step_s,
                      gap_spread(gap, samples_, frame_.bias, noise_, options_));
}

}  // namespace

void PreintegrationOptions::describe(Config& config) {
  config.field("max_gap_s", max_gap_s, "longest gap of the IMU that is not marked degraded [s]");
  config.field("max_bridge_s", max_bridge_s, "longest gap of the IMU that is bridged at all [s]");
  config.field("max_step_s", max_step_s, "longest integration step [s]");
  config.field("gap_correlation_s", gap_correlation_s,
               "time after which motion in a gap is unrelated to that before it [s]");
  config.field("gap_strength", gap_strength, "unseen motion in long gaps, relative to the seen");
  config.field("gap_gyro_floor", gap_gyro_floor, "angular rate to expect in any gap [rad/s]");
  config.field("gap_accel_floor", gap_accel_floor, "acceleration to expect in any gap [m/s^2]");
}

void PreintegrationOptions::validate() const {
  check_option(max_gap_s > 0.0, "preintegration.max_gap_s", max_gap_s, "> 0");
  check_option(max_bridge_s >= max_gap_s && max_bridge_s <= 60.0, "preintegration.max_bridge_s",
               max_bridge_s, ">= max_gap_s and <= 60");
  check_option(max_step_s >= 1e-4 && max_step_s <= 1.0, "preintegration.max_step_s", max_step_s,
               "between 0.0001 and 1");
  check_option(gap_correlation_s > 0.0, "preintegration.gap_correlation_s", gap_correlation_s,
               "> 0");
  check_option(gap_strength > 0.0, "preintegration.gap_strength", gap_strength, "> 0");
  check_option(gap_gyro_floor >= 0.0, "preintegration.gap_gyro_floor", gap_gyro_floor, ">= 0");
  check_option(gap_accel_floor >= 0.0, "preintegration.gap_accel_floor", gap_accel_floor, ">= 0");
}

ImuMotion preintegrate(ImuRange samples,
                       std::int64_t time0_ns,
                       std::int64_t time1_ns,
                       const ImuBias& bias,
                       const ImuNoise& noise,
                       double time_offset_s,
                       const PreintegrationOptions& options) {
  expects(time0_ns < time1_ns, "preintegrate: time0_ns must be before time1_ns");
  expects(std::abs(time_offset_s) <= kLargestOffset_s, "preintegrate: time_offset_s too large");
  ImuMotion frame;
  frame.time0_ns = time0_ns;
  frame.time1_ns = time1_ns;
  frame.dt_s = to_seconds(time1_ns - time0_ns);
  frame.bias = bias;
  frame.time_offset_s = time_offset_s;
  frame.covariance *= kUnknownVariance;
  frame.degraded = true;
  return IntervalWalk(samples, frame, noise, options).run();
}

ImuMotion correct_for_bias(const ImuMotion& motion, const ImuBias& new_bias) {
  Eigen::Matrix<double, 6, 1> change;
  change << new_bias.gyro - motion.bias.gyro, new_bias.accel - motion.bias.accel;
  ImuMotion corrected = motion;
  corrected.bias = new_bias;
  corrected.dR = motion.dR * lie::SO3d::exp(motion.J_dR_bias * change);
  corrected.dv += motion.J_dv_bias * change;
  corrected.dp += motion.J_dp_bias * change;
  return corrected;
}

ImuMotion correct_for_time_offset(const ImuMotion& motion, double new_time_offset_s) {
  const Eigen::Matrix<double, 9, 1> change =
      motion.J_time_offset * (new_time_offset_s - motion.time_offset_s);
  ImuMotion corrected = motion;
  corrected.time_offset_s = new_time_offset_s;
  corrected.dR = motion.dR * lie::SO3d::exp(change.head<3>());
  corrected.dv += change.segment<3>(3);
  corrected.dp += change.tail<3>();
  return corrected;
}

lie::NavState predict(const lie::NavState& state0,
                      const ImuMotion& motion,
                      const Eigen::Vector3d& gravity_world) {
  const double dt = motion.dt_s;
  const lie::SO3d& R0 = state0.T_world_body.rotation();
  const Eigen::Vector3d p1 = state0.T_world_body.translation() + dt * state0.v_world +
                             0.5 * dt * dt * gravity_world + R0 * motion.dp;
  return {lie::SE3d(R0 * motion.dR, p1), state0.v_world + dt * gravity_world + R0 * motion.dv};
}

ImuMotion motion_between(const lie::NavState& state0,
                         const lie::NavState& state1,
                         double dt_s,
                         const Eigen::Vector3d& gravity_world) {
  const lie::SO3d R0_inverse = state0.T_world_body.rotation().inverse();
  ImuMotion motion;
  motion.dt_s = dt_s;
  motion.dR = R0_inverse * state1.T_world_body.rotation();
  motion.dv = R0_inverse * (state1.v_world - state0.v_world - dt_s * gravity_world);
  motion.dp = R0_inverse * (state1.T_world_body.translation() - state0.T_world_body.translation() -
                            dt_s * state0.v_world - 0.5 * dt_s * dt_s * gravity_world);
  return motion;
}

Eigen::Matrix<double, 9, 1> difference(const ImuMotion& motion, const ImuMotion& reference) {
  Eigen::Matrix<double, 9, 1> result;
  result << (reference.dR.inverse() * motion.dR).log(), motion.dv - reference.dv,
      motion.dp - reference.dp;
  return result;
}

}  // namespace imslam::imu
