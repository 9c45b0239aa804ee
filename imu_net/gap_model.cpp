#include "imu_net/gap_model.hpp"

#include <algorithm>
#include <cmath>

#include "imu_net/sample_health.hpp"
#include "slam/base/error.hpp"
#include "slam/base/time.hpp"

namespace imslam::imu {
namespace {

constexpr int kVibrationSamples = 10;  ///< looked at on either side of the gap
constexpr double kNeighbourPeriods = 1.5;

/// Sum of squared differences between neighbouring samples; white noise has twice its variance.
struct Scatter {
  double rate = 0.0, force = 0.0;
  int count = 0;

  void add(const ImuSample& a, const ImuSample& b, const ImuNoise& noise) {
    if (sample_health(a, noise) != SampleHealth::kGood) return;
    if (sample_health(b, noise) != SampleHealth::kGood) return;
    if (to_seconds(b.time_ns - a.time_ns) * noise.rate_hz > kNeighbourPeriods) return;
    rate += (b.angular_velocity - a.angular_velocity).squaredNorm();
    force += (b.linear_acceleration - a.linear_acceleration).squaredNorm();
    ++count;
  }
};

GapSpread vibration(const Gap& gap, ImuRange samples, const ImuNoise& noise) {
  Scatter scatter;
  for (const ImuSample* s = gap.before; s != nullptr && s != samples.begin(); --s) {
    if (gap.before - s >= kVibrationSamples) break;
    scatter.add(*(s - 1), *s, noise);
  }
  for (const ImuSample* s = gap.after; s != nullptr && s + 1 != samples.end(); ++s) {
    if (s - gap.after >= kVibrationSamples) break;
    scatter.add(*s, *(s + 1), noise);
  }
  if (scatter.count == 0) return {};
  const double per_axis = 1.0 / (2.0 * 3.0 * scatter.count);
  return {std::sqrt(scatter.rate * per_axis), std::sqrt(scatter.force * per_axis)};
}

}  // namespace

GapSpread gap_spread(const Gap& gap,
                     double interval_s,
                     ImuRange samples,
                     const ImuBias& bias,
                     const ImuNoise& noise,
                     const PreintegrationOptions& options) {
  expects(gap.before != nullptr || gap.after != nullptr, "gap_spread: a gap needs an end");
  const bool both = gap.before != nullptr && gap.after != nullptr;
  const ImuSample& a = gap.before != nullptr ? *gap.before : *gap.after;
  const ImuSample& b = gap.after != nullptr ? *gap.after : *gap.before;
  const double ratio = gap.length_s / options.gap_correlation_s;
  const double share = 1.0 - std::exp(both && !gap.saturated ? -ratio * ratio : -ratio);

  const double rate =
      std::max((a.angular_velocity - bias.gyro).norm(), (b.angular_velocity - bias.gyro).norm());
  const double force = std::max(a.linear_acceleration.norm(), b.linear_acceleration.norm());
  const double change = (b.linear_acceleration - a.linear_acceleration).norm();
  // The specific force is mostly gravity, which turns against the body.
  const double swing = force * std::min(1.0, rate * gap.length_s);
  const double scale = share * options.gap_strength;
  const GapSpread shake = vibration(gap, samples, noise);
  const double shared = std::sqrt(std::max(1.0, gap.length_s / interval_s));
  return {shared * std::hypot(scale * (options.gap_gyro_floor + rate), shake.rate),
          shared * std::hypot(scale * (options.gap_accel_floor + swing + change), shake.force)};
}

}  // namespace imslam::imu
