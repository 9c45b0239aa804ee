#include "imu_net/imu_bin.hpp"

#include <algorithm>

#include "imu_net/sample_health.hpp"
#include "slam/base/time.hpp"

namespace imslam::imu {

namespace {

constexpr double kLongestDifference_s = 0.03;  // readings farther apart differ by motion

}  // namespace

const std::vector<ImuBin>& BinAccumulator::add(const ImuSample& sample) {
  closed_.clear();
  if (!begun_) {
    begun_ = true;
    open_.end_ns = sample.time_ns + ImuBin::kLength_ns;
  }
  if (sample.time_ns >= open_.end_ns) {
    close();
    const std::int64_t empty = (sample.time_ns - open_.end_ns) / ImuBin::kLength_ns;
    if (empty > kLongestGap) open_.end_ns += (empty - kLongestGap) * ImuBin::kLength_ns;
    while (sample.time_ns >= open_.end_ns) close();
  }
  if (sample_health(sample, noise_) != SampleHealth::kGood) return closed_;
  if (open_.count == 0) open_.rate = open_.force = Eigen::Vector3d::Zero();
  ++open_.count;
  open_.rate += (sample.angular_velocity - open_.rate) / open_.count;
  open_.force += (sample.linear_acceleration - open_.force) / open_.count;
  if (previous_) {
    const double dt_s = to_seconds(sample.time_ns - previous_->time_ns);
    if (dt_s < kLongestDifference_s) {
      rate_square_ += dt_s * (sample.angular_velocity - previous_->angular_velocity).cwiseAbs2();
      force_square_ +=
          dt_s * (sample.linear_acceleration - previous_->linear_acceleration).cwiseAbs2();
      ++differences_;
    }
  }
  previous_ = sample;
  return closed_;
}

/// The difference of two readings has twice their variance; density^2 = variance / rate.
void BinAccumulator::close() {
  if (differences_ > 0) {
    open_.gyro_density = (rate_square_ / (2.0 * differences_)).cwiseSqrt();
    open_.accel_density = (force_square_ / (2.0 * differences_)).cwiseSqrt();
  }
  closed_.push_back(open_);
  open_.end_ns += ImuBin::kLength_ns;
  open_.count = 0;
  rate_square_ = force_square_ = Eigen::Vector3d::Zero();
  differences_ = 0;
}

}  // namespace imslam::imu
