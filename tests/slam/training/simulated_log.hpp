#pragma once

#include "slam/training/inertial_log.hpp"
#include "tests/imu_net/synthetic_motion.hpp"

namespace imslam::training::testing {

/// Errorless readings of the swaying body at `rate_hz` and its true states at `truth_hz`.
inline InertialLog sine_log(double duration_s, double rate_hz = 200.0, double truth_hz = 20.0) {
  const imu::testing::SineMotion motion;
  InertialLog log;
  log.name = "sine";
  log.noise.rate_hz = rate_hz;
  log.samples = motion.samples(0.0, duration_s, rate_hz);
  const int states = static_cast<int>(duration_s * truth_hz) + 1;
  for (int i = 0; i < states; ++i) {
    const double t = i / truth_hz;
    log.truth.push_back({imu::testing::stamp(t), motion.state(t)});
  }
  return log;
}

/// The same with the datasheet's white noise and a constant bias.
inline InertialLog noisy_sine_log(double duration_s, const ImuBias& bias, std::uint64_t seed) {
  InertialLog log = sine_log(duration_s);
  Random random(seed);
  imu::testing::disturb(log.samples, bias, log.noise, random);
  return log;
}

}  // namespace imslam::training::testing
