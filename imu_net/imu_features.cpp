#include "imu_net/imu_features.hpp"

#include <algorithm>
#include <cmath>

#include "slam/base/error.hpp"
#include "slam/base/time.hpp"

namespace imslam::imu {

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

/// What the observers believe of the bias.
struct Beliefs {
  BiasBelief rest, gravity, quick, mean, accel;
};

/// Against the datasheet's noise.
void put_shaking(const ImuBin& bin, const ImuNoise& noise, int axis, FeatureWriter& out) {
  const double root3 = std::sqrt(3.0);
  out.put(decades(bin.gyro_density[axis] / noise.gyro_noise_density, 0.05, 3.0));
  out.put(decades(bin.gyro_density.norm() / root3 / noise.gyro_noise_density, 0.05, 3.0));
  out.put(decades(bin.accel_density[axis] / noise.accel_noise_density, 0.05, 3.0));
  out.put(decades(bin.accel_density.norm() / root3 / noise.accel_noise_density, 0.05, 3.0));
}

/// How firmly each is believed, how large it is, and where they differ.
void put_beliefs(const Beliefs& b, int axis, FeatureWriter& out) {
  const auto difference = [&](const BiasBelief& x, const BiasBelief& y) {
    return decades(std::abs(x.bias[axis] - y.bias[axis]), 1e-4, 1e-2);
  };
  out.put(decades(b.rest.sigma[axis], 1e-4, 5e-3));
  out.put(decades(b.gravity.sigma[axis], 1e-4, 5e-3));
  out.put(decades(b.quick.sigma[axis], 1e-4, 5e-3));
  out.put(decades(b.mean.sigma[axis], 1e-4, 2e-2));
  for (const BiasBelief* belief : {&b.rest, &b.gravity, &b.quick, &b.mean}) {
    out.put(decades(std::abs(belief->bias[axis]), 1e-4, 1e-2));
  }
  out.put(difference(b.rest, b.gravity));
  out.put(difference(b.rest, b.mean));
  out.put(difference(b.gravity, b.quick));
  out.put(difference(b.gravity, b.mean));
  out.put(difference(b.quick, b.mean));
  out.put(decades(b.accel.sigma[axis], 3e-3, 0.1));
  out.put(decades(std::abs(b.accel.bias[axis]), 3e-3, 0.1));
}

void put_sensor(const ImuNoise& noise, FeatureWriter& out) {
  out.put(decades(noise.gyro_noise_density, 1e-6, 2e-4));
  out.put(decades(noise.accel_noise_density, 1e-5, 2e-3));
  out.put(decades(noise.gyro_random_walk, 1e-7, 2e-5) / 2.0);
  out.put(decades(noise.rate_hz, 10.0, 200.0));
}

Eigen::Vector3d cut(const Eigen::Vector3d& bias, double largest) {
  return bias.cwiseMax(-largest).cwiseMin(largest);
}

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
  const Beliefs b{rest_.gyro(), gravity_.gyro(), quick_gravity_.gyro(), mean_.gyro(),
                  rest_.accel()};
  const double excess = bin.force.norm() - kGravity;
  const double share = std::min(1.0, dt_s / ImuBin::kLength_s / kRecentBins);
  rate_square_ += share * ((bin.rate - b.mean.bias).cwiseAbs2() - rate_square_);
  force_square_ += share * (excess * excess - force_square_);

  ImuFrame frame;
  frame.time_ns = bin.end_ns;
  frame.gyro_bias = {cut(b.rest.bias, kLargestBias), cut(b.gravity.bias, kLargestBias),
                     cut(b.quick.bias, kLargestBias), cut(b.mean.bias, kLargestBias)};
  frame.accel_bias = {cut(b.accel.bias, kLargestAccelBias)};
  for (int i = 0; i < 3; ++i) {
    FeatureWriter out(frame.features[static_cast<std::size_t>(i)]);
    put_shaking(bin, noise_, i, out);
    put_motion(bin, bin.rate - b.rest.bias, i, out);
    put_beliefs(b, i, out);
    out.put(rest_.still() ? 1.0 : -1.0);
    out.put(decades(rest_.time_since_rest_s(), 0.1, 10.0));
    out.put(decades(to_seconds(bin.end_ns - start_ns_), 0.1, 10.0));
    out.put(bin.count > 0 ? -1.0 : 1.0);
    put_sensor(noise_, out);
    expects(out.full(), "FeatureExtractor: as many features as the frame holds");
  }
  return frame;
}

void FeatureExtractor::put_motion(const ImuBin& bin,
                                  const Eigen::Vector3d& rate,
                                  int axis,
                                  FeatureWriter& out) const {
  out.put(decades(std::abs(rate[axis]), 1e-3, 0.1));
  out.put(decades(rate.norm(), 1e-3, 0.1));
  out.put(decades(std::abs(bin.rate[axis] - previous_.rate[axis]), 1e-3, 0.03));
  out.put(decades(std::sqrt(rate_square_[axis]), 1e-3, 0.1));
  out.put(decades(rate_square_.norm(), 1e-6, 1e-2) / 2.0);
  out.put(decades(std::abs(bin.force.norm() - kGravity), 0.02, 0.3));
  out.put(decades((bin.force - previous_.force).norm(), 0.02, 0.3));
  out.put(decades(std::sqrt(force_square_), 0.02, 0.3));
  const double level = bin.force[axis] / std::max(1.0, bin.force.norm());
  out.put(2.0 * level * level - 1.0);
}

}  // namespace imslam::imu
