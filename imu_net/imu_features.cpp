#include "imu_net/imu_features.hpp"

#include <algorithm>
#include <cmath>

#include "slam/base/error.hpp"
#include "slam/base/time.hpp"

namespace imslam::imu {
namespace {

constexpr GravityObserver::Accelerations kLastingAccelerations{0.5, 40.0};
constexpr GravityObserver::Accelerations kBriefAccelerations{0.3, 8.0};
constexpr double kGravity = 9.81;          // [m/s^2]
constexpr double kRecentBins = 50.0;       // over which motion is averaged
constexpr double kLargestBias = 0.25;      // [rad/s] a candidate beyond it is cut
constexpr double kLargestAccelBias = 1.0;  // [m/s^2]

/// Decades of x above `low`, zero at `middle`; x below `low` counts as `low`.
double decades(double x, double low, double middle) {
  return std::log10(std::max(x, low) / middle);
}

/// Writes one axis's features one after the other.
class FeatureWriter {
 public:
  explicit FeatureWriter(std::array<float, ImuFrame::kFeatures>& out) : out_(out) {}
  void put(double value) { out_.at(next_++) = static_cast<float>(std::clamp(value, -3.0, 3.0)); }
  bool full() const { return next_ == out_.size(); }

 private:
  std::array<float, ImuFrame::kFeatures>& out_;
  std::size_t next_ = 0;
};

}  // namespace

FeatureExtractor::FeatureExtractor(const ImuNoise& noise)
    : noise_(noise),
      bins_(noise),
      rest_(noise),
      gravity_(noise, kLastingAccelerations),
      quick_gravity_(noise, kBriefAccelerations) {}

const std::vector<ImuFrame>& FeatureExtractor::add(const ImuSample& sample) {
  frames_.clear();
  for (const ImuBin& bin : bins_.add(sample)) {
    if (!begun_) {
      begun_ = true;
      start_ns_ = last_end_ns_ = bin.end_ns - ImuBin::kLength_ns;
      previous_ = bin;
    }
    const double dt_s = to_seconds(bin.end_ns - last_end_ns_);  // more than a bin: a long gap
    last_end_ns_ = bin.end_ns;
    rest_.add(bin, dt_s);
    gravity_.add(bin, dt_s, rest_.reading());
    quick_gravity_.add(bin, dt_s, rest_.reading());
    mean_.add(bin);
    frames_.push_back(describe(bin, dt_s));
    previous_ = bin;
  }
  return frames_;
}

ImuFrame FeatureExtractor::describe(const ImuBin& bin, double dt_s) {
  const BiasBelief rest = rest_.gyro();
  const BiasBelief gravity = gravity_.gyro();
  const BiasBelief quick = quick_gravity_.gyro();
  const BiasBelief mean = mean_.gyro();
  const BiasBelief accel = rest_.accel();
  const Eigen::Vector3d rate = bin.rate - rest.bias;
  const double excess = bin.force.norm() - kGravity;
  const double share = std::min(1.0, dt_s / ImuBin::kLength_s / kRecentBins);
  rate_square_ += share * ((bin.rate - mean.bias).cwiseAbs2() - rate_square_);
  force_square_ += share * (excess * excess - force_square_);

  ImuFrame frame;
  frame.time_ns = bin.end_ns;
  const auto cut = [](const Eigen::Vector3d& bias, double largest) {
    return bias.cwiseMax(-largest).cwiseMin(largest).eval();
  };
  frame.gyro_bias = {cut(rest.bias, kLargestBias), cut(gravity.bias, kLargestBias),
                     cut(quick.bias, kLargestBias), cut(mean.bias, kLargestBias)};
  frame.accel_bias = {cut(accel.bias, kLargestAccelBias)};
  const double root3 = std::sqrt(3.0);
  for (int i = 0; i < 3; ++i) {
    FeatureWriter out(frame.features[static_cast<std::size_t>(i)]);
    // How much it shakes, against the datasheet's noise.
    out.put(decades(bin.gyro_density[i] / noise_.gyro_noise_density, 0.05, 3.0));
    out.put(decades(bin.gyro_density.norm() / root3 / noise_.gyro_noise_density, 0.05, 3.0));
    out.put(decades(bin.accel_density[i] / noise_.accel_noise_density, 0.05, 3.0));
    out.put(decades(bin.accel_density.norm() / root3 / noise_.accel_noise_density, 0.05, 3.0));
    // How it moves.
    out.put(decades(std::abs(rate[i]), 1e-3, 0.1));
    out.put(decades(rate.norm(), 1e-3, 0.1));
    out.put(decades(std::abs(bin.rate[i] - previous_.rate[i]), 1e-3, 0.03));
    out.put(decades(std::sqrt(rate_square_[i]), 1e-3, 0.1));
    out.put(decades(rate_square_.norm(), 1e-6, 1e-2) / 2.0);
    out.put(decades(std::abs(excess), 0.02, 0.3));
    out.put(decades((bin.force - previous_.force).norm(), 0.02, 0.3));
    out.put(decades(std::sqrt(force_square_), 0.02, 0.3));
    const double level = bin.force[i] / std::max(1.0, bin.force.norm());
    out.put(2.0 * level * level - 1.0);
    // What the observers believe, how firmly, and where they differ.
    out.put(decades(rest.sigma[i], 1e-4, 5e-3));
    out.put(decades(gravity.sigma[i], 1e-4, 5e-3));
    out.put(decades(quick.sigma[i], 1e-4, 5e-3));
    out.put(decades(mean.sigma[i], 1e-4, 2e-2));
    out.put(decades(std::abs(rest.bias[i]), 1e-4, 1e-2));
    out.put(decades(std::abs(gravity.bias[i]), 1e-4, 1e-2));
    out.put(decades(std::abs(quick.bias[i]), 1e-4, 1e-2));
    out.put(decades(std::abs(mean.bias[i]), 1e-4, 1e-2));
    out.put(decades(std::abs(rest.bias[i] - gravity.bias[i]), 1e-4, 1e-2));
    out.put(decades(std::abs(rest.bias[i] - mean.bias[i]), 1e-4, 1e-2));
    out.put(decades(std::abs(gravity.bias[i] - quick.bias[i]), 1e-4, 1e-2));
    out.put(decades(std::abs(gravity.bias[i] - mean.bias[i]), 1e-4, 1e-2));
    out.put(decades(std::abs(quick.bias[i] - mean.bias[i]), 1e-4, 1e-2));
    out.put(decades(accel.sigma[i], 3e-3, 0.1));
    out.put(decades(std::abs(accel.bias[i]), 3e-3, 0.1));
    // Since when, and with which sensor.
    out.put(rest_.still() ? 1.0 : -1.0);
    out.put(decades(rest_.time_since_rest_s(), 0.1, 10.0));
    out.put(decades(to_seconds(bin.end_ns - start_ns_), 0.1, 10.0));
    out.put(bin.count > 0 ? -1.0 : 1.0);
    out.put(decades(noise_.gyro_noise_density, 1e-6, 2e-4));
    out.put(decades(noise_.accel_noise_density, 1e-5, 2e-3));
    out.put(decades(noise_.gyro_random_walk, 1e-7, 2e-5) / 2.0);
    out.put(decades(noise_.rate_hz, 10.0, 200.0));
    expects(out.full(), "FeatureExtractor: as many features as the frame holds");
  }
  return frame;
}

}  // namespace imslam::imu
