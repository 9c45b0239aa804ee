#pragma once

#include <gtest/gtest.h>

#include <Eigen/Core>
#include <string>
#include <vector>

#include "imu_net/preintegration.hpp"
#include "imu_net/preintegration_gradient.hpp"
#include "tests/imu_net/synthetic_motion.hpp"
#include "tests/support/numeric_jacobian.hpp"

namespace imslam::imu::testing {

/// One call of preintegrate().
struct Interval {
  std::string name;
  std::vector<ImuSample> samples;
  double t0 = 0.0, t1 = 0.0;
  ImuBias bias{{0.01, -0.02, 0.03}, {0.1, 0.05, -0.08}};
  double time_offset_s = 0.0;
  PreintegrationOptions options{};

  /// Loud enough for central differences of the covariance.
  static ImuNoise noise() {
    ImuNoise noise;
    noise.gyro_noise_density = 0.05;
    noise.accel_noise_density = 0.5;
    return noise;
  }
  ImuMotion run(PreintegrationRecord* record = nullptr) const {
    return preintegrate(samples, stamp(t0), stamp(t1), bias, noise(), time_offset_s, options,
                        record);
  }
};

/// Gives every sample variances of its own, per axis, of about the size of the noise above.
inline std::vector<ImuSample> with_random_variances(std::vector<ImuSample> samples) {
  Random random(3);
  for (ImuSample& sample : samples) {
    sample.gyro_variance = 2e-3 * random.normal3().cwiseAbs().array() + 1e-3;
    sample.accel_variance = 0.2 * random.normal3().cwiseAbs().array() + 0.1;
  }
  return samples;
}

/// All inputs in one vector: 12 numbers for each of the samples from `first` on, then the bias.
struct Inputs {
  std::size_t first = 0, count = 0;

  Eigen::Index size() const { return static_cast<Eigen::Index>(12 * count + 6); }
  Interval moved(Interval interval, const Eigen::VectorXd& d) const {
    for (std::size_t i = 0; i < count; ++i) {
      ImuSample& sample = interval.samples[first + i];
      const auto at = static_cast<Eigen::Index>(12 * i);
      sample.angular_velocity += d.segment<3>(at);
      sample.linear_acceleration += d.segment<3>(at + 3);
      sample.gyro_variance += d.segment<3>(at + 6);
      sample.accel_variance += d.segment<3>(at + 9);
    }
    interval.bias.gyro += d.segment<3>(size() - 6);
    interval.bias.accel += d.segment<3>(size() - 3);
    return interval;
  }
  Eigen::VectorXd gather(const std::vector<SampleGradient>& gradients, const ImuBias& bias) const {
    Eigen::VectorXd all(size());
    for (std::size_t i = 0; i < count; ++i) {
      const SampleGradient& g = gradients[first + i];
      all.segment<12>(static_cast<Eigen::Index>(12 * i)) << g.angular_velocity,
          g.linear_acceleration, g.gyro_variance, g.accel_variance;
    }
    all.tail<6>() << bias.gyro, bias.accel;
    return all;
  }
};

/// The samples within 10 ms of the interval.
inline Inputs inputs_around(const Interval& interval) {
  const std::int64_t margin_ns = 10'000'000;
  const std::int64_t offset_ns = to_nanoseconds(interval.time_offset_s);
  const ImuRange all = interval.samples;
  const ImuSample* first = all.after(stamp(interval.t0) + offset_ns - margin_ns);
  const ImuSample* last = all.after(stamp(interval.t1) + offset_ns + margin_ns);
  return {static_cast<std::size_t>(first - all.begin()), static_cast<std::size_t>(last - first)};
}

/// r^T Sigma^-1 r + log det Sigma for r = difference(motion, target).
inline double negative_log_likelihood(const ImuMotion& motion, const ImuMotion& target) {
  const Eigen::Matrix<double, 9, 1> r = difference(motion, target);
  const Eigen::LLT<Eigen::Matrix<double, 9, 9>> factor(motion.covariance);
  const Eigen::Matrix<double, 9, 9> L = factor.matrixL();
  return r.dot(factor.solve(r)) + 2.0 * L.diagonal().array().log().sum();
}

inline MotionGradient likelihood_gradient(const ImuMotion& motion, const ImuMotion& target) {
  const Eigen::Matrix<double, 9, 1> r = difference(motion, target);
  const Eigen::Matrix<double, 9, 9> information = motion.covariance.inverse();
  const Eigen::Matrix<double, 9, 1> weighted = information * r;
  MotionGradient gradient;
  gradient.motion = 2.0 * weighted;
  const Eigen::Vector3d theta = r.head<3>();
  gradient.motion.head<3>() =
      lie::SO3d::right_jacobian_inverse(theta).transpose() * gradient.motion.head<3>();
  gradient.covariance = information - weighted * weighted.transpose();
  return gradient;
}

}  // namespace imslam::imu::testing
