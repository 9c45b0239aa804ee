#include "imu_net/vibration_meter.hpp"

#include <algorithm>
#include <cmath>

#include "imu_net/sample_health.hpp"
#include "slam/base/time.hpp"

namespace imslam::imu {
namespace {

constexpr double kMemory_s = 0.5;
constexpr double kLongestBin_s = 0.04;
constexpr double kNeighbourPeriods = 1.5;
constexpr double kWhiteNoiseGain = 20.0;  // 1 + 9 + 9 + 1: of third differences
/// Variance of a mean of n squared third differences of white noise, times n: 2 for the squares,
/// 2.31 for what neighbouring differences have in common.
constexpr double kScatter = 4.62;
/// A single wrong reading is no vibration; one that starts is believed within a few readings.
constexpr double kLargestJump = 30.0;

}  // namespace

VibrationMeter::VibrationMeter(const ImuNoise& noise) : noise_(noise) {
  stated_.head<3>().setConstant(std::pow(noise.gyro_noise_density, 2) * noise.rate_hz);
  stated_.tail<3>().setConstant(std::pow(noise.accel_noise_density, 2) * noise.rate_hz);
  int length = 1;
  do {
    scales_.emplace_back().length = length;
    length *= 2;
  } while (length <= 1.01 * kLongestBin_s * noise.rate_hz);
}

ImuSample VibrationMeter::add(const ImuSample& sample) {
  const double since_s = to_seconds(sample.time_ns - last_ns_);
  const bool neighbour = since_s * noise_.rate_hz < kNeighbourPeriods;
  const bool usable = sample_health(sample, noise_) == SampleHealth::kGood;
  last_ns_ = sample.time_ns;
  Axes reading;
  reading << sample.angular_velocity.array(), sample.linear_acceleration.array();
  for (Scale& scale : scales_) {
    if (!usable || !neighbour) {
      scale.filled = 0;
      scale.in_a_row = 0;
    }
    if (usable) look_at(reading, scale);
  }
  const Axes added = (lowest_bound() - stated_).max(0.0) / noise_.rate_hz;
  ImuSample result = sample;
  result.gyro_variance += added.head<3>().matrix();
  result.accel_variance += added.tail<3>().matrix();
  return result;
}

void VibrationMeter::look_at(const Axes& reading, Scale& scale) const {
  if (scale.filled++ == 0) scale.sum.setZero();
  scale.sum += reading;
  if (scale.filled < scale.length) return;
  scale.filled = 0;
  close_bin(scale.sum / scale.length, scale);
}

void VibrationMeter::close_bin(const Axes& mean, Scale& scale) const {
  if (scale.in_a_row >= 3) {
    const Axes difference = mean - 3.0 * (scale.last[0] - scale.last[1]) - scale.last[2];
    const Axes seen = (difference.square() * (scale.length / kWhiteNoiseGain))
                          .min(kLargestJump * scale.variance.max(stated_));
    const double news = 1.0 - std::exp(-scale.length / (kMemory_s * noise_.rate_hz));
    scale.variance += std::max(news, 1.0 / ++scale.looked) * (seen - scale.variance);
  }
  ++scale.in_a_row;
  scale.last = {mean, scale.last[0], scale.last[1]};
}

/// Longer bins scatter more: they count if they are lower by that, lest the lowest be so by chance.
VibrationMeter::Axes VibrationMeter::lowest_bound() const {
  Axes bound = Axes::Zero();
  bool found = false;
  for (const Scale& scale : scales_) {
    if (scale.looked == 0) continue;
    const Axes sure = scale.variance * (1.0 + scatter_of(scale)) / (1.0 + scatter_of(scales_[0]));
    bound = found ? bound.min(sure).eval() : sure;
    found = true;
  }
  return bound;
}

double VibrationMeter::scatter_of(const Scale& scale) const {
  const double remembered = 2.0 * kMemory_s * noise_.rate_hz / scale.length;
  return std::sqrt(kScatter / std::min<double>(scale.looked, remembered));
}

}  // namespace imslam::imu
