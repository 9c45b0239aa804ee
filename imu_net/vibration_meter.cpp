#include "imu_net/vibration_meter.hpp"

#include <algorithm>
#include <cmath>

#include "imu_net/sample_health.hpp"
#include "slam/base/time.hpp"

namespace imslam::imu {
namespace {

constexpr double kMemory_s = 0.5;
constexpr double kNeighbourPeriods = 1.5;
constexpr double kWhiteNoiseGain = 20.0;  // 1 + 9 + 9 + 1: of third differences
/// A single wrong reading is no vibration; one that starts is believed within a few readings.
constexpr double kLargestJump = 30.0;

}  // namespace

ImuSample VibrationMeter::add(const ImuSample& sample) {
  const double since_s = to_seconds(sample.time_ns - last_ns_);
  const bool neighbour = since_s * noise_.rate_hz < kNeighbourPeriods;
  const bool usable = sample_health(sample, noise_) == SampleHealth::kGood;
  if (!usable || !neighbour) in_a_row_ = 0;
  last_ns_ = sample.time_ns;
  if (usable) {
    Axes reading;
    reading << sample.angular_velocity.array(), sample.linear_acceleration.array();
    look_at(reading);
  }
  const Axes density_sq = variance_ / noise_.rate_hz;
  const double gyro_sq = noise_.gyro_noise_density * noise_.gyro_noise_density;
  const double accel_sq = noise_.accel_noise_density * noise_.accel_noise_density;
  ImuSample result = sample;
  result.gyro_variance += (density_sq.head<3>() - gyro_sq).max(0.0).matrix();
  result.accel_variance += (density_sq.tail<3>() - accel_sq).max(0.0).matrix();
  return result;
}

void VibrationMeter::look_at(const Axes& reading) {
  if (in_a_row_ >= 3) {
    const Axes difference = reading - 3.0 * (last_[0] - last_[1]) - last_[2];
    Axes stated;
    stated.head<3>().setConstant(std::pow(noise_.gyro_noise_density, 2) * noise_.rate_hz);
    stated.tail<3>().setConstant(std::pow(noise_.accel_noise_density, 2) * noise_.rate_hz);
    const Axes seen =
        (difference.square() / kWhiteNoiseGain).min(kLargestJump * variance_.max(stated));
    const double news = 1.0 - std::exp(-1.0 / (kMemory_s * noise_.rate_hz));
    variance_ += std::max(news, 1.0 / ++looked_) * (seen - variance_);
  }
  ++in_a_row_;
  last_ = {reading, last_[0], last_[1]};
}

}  // namespace imslam::imu
