#include "imu_net/static_detector.hpp"

#include <algorithm>
#include <cmath>
#include <vector>

#include "imu_net/option_bounds.hpp"
#include "imu_net/sample_health.hpp"
#include "slam/base/config.hpp"
#include "slam/base/error.hpp"
#include "slam/base/time.hpp"

namespace imslam::imu {
namespace {

constexpr double kGravity = 9.81;  ///< [m/s^2]
constexpr int kMinimumBins = 4;

/// Means [rate force] over each bin that holds a usable reading.
std::vector<BinMean> bin_means(
    ImuRange window, std::int64_t time0_ns, std::size_t bins, double bin_s, const ImuNoise& noise) {
  std::vector<BinMean> sums(bins, BinMean::Zero());
  std::vector<int> counts(bins, 0);
  for (const ImuSample& sample : window) {
    const double position = to_seconds(sample.time_ns - time0_ns) / bin_s;
    if (position < 0.0 || sample_health(sample, noise) != SampleHealth::kGood) continue;
    const auto bin = static_cast<std::size_t>(position);
    if (bin >= bins) break;
    sums[bin].head<3>() += sample.angular_velocity;
    sums[bin].tail<3>() += sample.linear_acceleration;
    ++counts[bin];
  }
  std::vector<BinMean> means;
  for (std::size_t i = 0; i < bins; ++i) {
    if (counts[i] > 0) means.push_back(sums[i] / counts[i]);
  }
  return means;
}

}  // namespace

void StaticDetectorOptions::describe(Config& config) {
  config.field("bin_s", bin_s, "readings are averaged over this time to hide vibration [s]");
  config.field("max_rate_spread", max_rate_spread, "largest spread of the rate at rest [rad/s]");
  config.field("max_force_spread", max_force_spread, "largest spread of the force at rest [m/s^2]");
  config.field("max_rate", max_rate, "largest mean rate at rest, i.e. gyro bias [rad/s]");
  config.field("max_gravity_error", max_gravity_error,
               "largest deviation of the mean force from 9.81 at rest [m/s^2]");
  config.field("noise_factor", noise_factor, "spreads may reach this many times the noise");
}

void StaticDetectorOptions::validate() const {
  check_option(bin_s > 0.0, "static.bin_s", bin_s, "> 0");
  check_option(max_rate_spread > 0.0, "static.max_rate_spread", max_rate_spread, "> 0");
  check_option(max_force_spread > 0.0, "static.max_force_spread", max_force_spread, "> 0");
  check_option(max_rate > 0.0, "static.max_rate", max_rate, "> 0");
  check_option(max_gravity_error > 0.0, "static.max_gravity_error", max_gravity_error, "> 0");
  check_option(noise_factor >= 0.0, "static.noise_factor", noise_factor, ">= 0");
}

Stillness assess_bins(const std::vector<BinMean>& means,
                      double wanted,
                      const ImuNoise& noise,
                      const StaticDetectorOptions& options) {
  Stillness result;
  result.bins = static_cast<int>(means.size());
  if (means.empty()) return result;

  BinMean mean = BinMean::Zero();
  for (const BinMean& bin : means) mean += bin / result.bins;
  BinMean variance = BinMean::Zero();
  for (const BinMean& bin : means) variance += (bin - mean).cwiseAbs2() / result.bins;
  const BinMean spread = variance.cwiseSqrt();
  result.mean_rate = mean.head<3>();
  result.mean_force = mean.tail<3>();
  result.rate_spread = spread.head<3>();
  result.force_spread = spread.tail<3>();

  const double scale = options.noise_factor / std::sqrt(options.bin_s);
  result.still = result.bins >= kMinimumBins && result.bins >= 0.8 * wanted &&
                 result.rate_spread.maxCoeff() <
                     std::max(options.max_rate_spread, scale * noise.gyro_noise_density) &&
                 result.force_spread.maxCoeff() <
                     std::max(options.max_force_spread, scale * noise.accel_noise_density) &&
                 result.mean_rate.norm() < options.max_rate &&
                 std::abs(result.mean_force.norm() - kGravity) < options.max_gravity_error;
  return result;
}

Stillness assess_stillness(ImuRange samples,
                           std::int64_t time0_ns,
                           std::int64_t time1_ns,
                           const ImuNoise& noise,
                           const StaticDetectorOptions& options) {
  expects(time0_ns < time1_ns, "assess_stillness: time0_ns must be before time1_ns");
  const double wanted = std::max(1.0, std::round(to_seconds(time1_ns - time0_ns) / options.bin_s));
  const ImuRange window = samples.around(time0_ns, time1_ns);
  const auto means =
      bin_means(window, time0_ns, static_cast<std::size_t>(wanted), options.bin_s, noise);
  return assess_bins(means, wanted, noise, options);
}

}  // namespace imslam::imu
