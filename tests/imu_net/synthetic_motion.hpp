#pragma once

#include <cmath>
#include <cstdint>
#include <vector>

#include "imu_net/preintegration.hpp"
#include "slam/base/random.hpp"
#include "slam/base/time.hpp"

namespace imslam::imu::testing {

inline const Eigen::Vector3d kGravity(0.0, 0.0, -9.81);
inline constexpr std::int64_t kOrigin_ns = 1'400'000'000'000'000'000;

/// A body that sways along smooth sines: everything about it is known in closed form.
///
///   R_world_body = Exp(z yaw) Exp(y pitch) Exp(x roll),   p = sines
class SineMotion {
 public:
  explicit SineMotion(double strength = 1.0) : strength_(strength) {}

  lie::NavState state(double t) const {
    const Wave yaw = wave(1.1, 0.9, 0.3, t);
    const Wave pitch = wave(0.5, 1.7, 1.1, t);
    const Wave roll = wave(0.4, 2.3, 2.0, t);
    const auto R = lie::SO3d::exp({0, 0, yaw.value}) * lie::SO3d::exp({0, pitch.value, 0}) *
                   lie::SO3d::exp({roll.value, 0, 0});
    const Wave x = wave(1.0, 1.3, 0.1, t);
    const Wave y = wave(0.7, 2.1, 0.7, t);
    const Wave z = wave(0.3, 2.9, 1.9, t);
    return {lie::SE3d(R, {x.value, y.value, z.value}), {x.slope, y.slope, z.slope}};
  }

  ImuSample sample(double t) const {
    const Wave yaw = wave(1.1, 0.9, 0.3, t);
    const Wave pitch = wave(0.5, 1.7, 1.1, t);
    const Wave roll = wave(0.4, 2.3, 2.0, t);
    const auto R_roll = lie::SO3d::exp({roll.value, 0, 0}).inverse();
    const auto R_pitch = lie::SO3d::exp({0, pitch.value, 0}).inverse();
    const Eigen::Vector3d acceleration(wave(1.0, 1.3, 0.1, t).bend, wave(0.7, 2.1, 0.7, t).bend,
                                       wave(0.3, 2.9, 1.9, t).bend);
    ImuSample sample;
    sample.time_ns = kOrigin_ns + to_nanoseconds(t);
    sample.angular_velocity =
        Eigen::Vector3d(roll.slope, 0, 0) +
        R_roll * (Eigen::Vector3d(0, pitch.slope, 0) + R_pitch * Eigen::Vector3d(0, 0, yaw.slope));
    sample.linear_acceleration =
        state(t).T_world_body.rotation().inverse() * (acceleration - kGravity);
    return sample;
  }

  /// Readings at `rate_hz` over [t0, t1], noise-free.
  std::vector<ImuSample> samples(double t0, double t1, double rate_hz) const {
    std::vector<ImuSample> result;
    const auto count = static_cast<int>(std::floor((t1 - t0) * rate_hz + 1e-9)) + 1;
    for (int i = 0; i < count; ++i) result.push_back(sample(t0 + i / rate_hz));
    return result;
  }

  /// The true increment between two times.
  ImuMotion truth(double t0, double t1) const {
    return motion_between(state(t0), state(t1), t1 - t0, kGravity);
  }

 private:
  struct Wave {
    double value, slope, bend;
  };
  Wave wave(double amplitude, double omega, double phase, double t) const {
    const double a = strength_ * amplitude;
    return {a * std::sin(omega * t + phase), a * omega * std::cos(omega * t + phase),
            -a * omega * omega * std::sin(omega * t + phase)};
  }
  double strength_;
};

inline std::int64_t stamp(double t) { return kOrigin_ns + to_nanoseconds(t); }

/// Adds a constant bias and the white noise of a datasheet to each reading.
inline void disturb(std::vector<ImuSample>& samples,
                    const ImuBias& bias,
                    const ImuNoise& noise,
                    Random& random) {
  const double root_rate = std::sqrt(noise.rate_hz);
  for (ImuSample& sample : samples) {
    sample.angular_velocity += bias.gyro + noise.gyro_noise_density * root_rate * random.normal3();
    sample.linear_acceleration +=
        bias.accel + noise.accel_noise_density * root_rate * random.normal3();
  }
}

}  // namespace imslam::imu::testing
