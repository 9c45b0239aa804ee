#include "imu_net/vibration_meter.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <optional>

#include "slam/base/random.hpp"
#include "slam/base/time.hpp"

namespace imslam::imu {
namespace {

/// Flies in circles and shakes by `factor(t)` times the stated noise.
class Shaken {
 public:
  explicit Shaken(double rate_hz = 200.0) {
    noise_.rate_hz = rate_hz;
    meter_.emplace(noise_);
  }

  ImuSample sample(double factor) {
    const double t_s = static_cast<double>(count_++) / noise_.rate_hz;
    const double wave = std::sin(2.0 * M_PI * 2.0 * t_s);
    const double scale = factor * std::sqrt(noise_.rate_hz);
    ImuSample result;
    result.time_ns = to_nanoseconds(t_s);
    for (int axis = 0; axis < 3; ++axis) {
      result.angular_velocity[axis] =
          0.5 * wave + scale * noise_.gyro_noise_density * random_.normal();
      result.linear_acceleration[axis] =
          9.81 + 3.0 * wave + scale * noise_.accel_noise_density * random_.normal();
    }
    return result;
  }
  /// The last answer after `seconds` more.
  ImuSample run(double seconds, double factor) {
    ImuSample said;
    for (double t_s = 0.0; t_s < seconds; t_s += 1.0 / noise_.rate_hz) said = add(sample(factor));
    return said;
  }
  ImuSample add(const ImuSample& sample) { return meter_->add(sample); }
  void skip(double seconds) { count_ += static_cast<int>(seconds * noise_.rate_hz); }

  /// What is added, in units of the stated variance: mean of the axes.
  double added_gyro(const ImuSample& said) const {
    return said.gyro_variance.mean() / std::pow(noise_.gyro_noise_density, 2);
  }
  double added_accel(const ImuSample& said) const {
    return said.accel_variance.mean() / std::pow(noise_.accel_noise_density, 2);
  }

 private:
  ImuNoise noise_;
  std::optional<VibrationMeter> meter_;
  Random random_{3};
  int count_ = 0;
};

TEST(VibrationMeter, AddsNothingToAReadingThatIsAsGoodAsStated) {
  Shaken sensor;
  for (int i = 0; i < 20; ++i) {
    const ImuSample said = sensor.run(0.5, 0.5);
    EXPECT_EQ(sensor.added_gyro(said), 0.0);
    EXPECT_EQ(sensor.added_accel(said), 0.0);
  }
}

TEST(VibrationMeter, FindsTheStrengthOfWhiteNoiseAtEveryRate) {
  for (const double rate_hz : {50.0, 200.0, 1000.0}) {
    Shaken sensor(rate_hz);
    sensor.run(2.0, 10.0);
    double gyro = 0.0;
    double accel = 0.0;
    for (int i = 0; i < 40; ++i) {
      const ImuSample said = sensor.run(0.5, 10.0);
      gyro += sensor.added_gyro(said) / 40.0;
      accel += sensor.added_accel(said) / 40.0;
    }
    EXPECT_NEAR(gyro, 99.0, 15.0) << rate_hz;
    EXPECT_NEAR(accel, 99.0, 15.0) << rate_hz;
  }
}

TEST(VibrationMeter, KeepsTheVariancesThatAreThere) {
  Shaken sensor;
  sensor.run(1.0, 0.5);
  ImuSample sample = sensor.sample(0.5);
  sample.gyro_variance.setConstant(0.25);
  EXPECT_EQ(sensor.add(sample).gyro_variance, sample.gyro_variance);
}

TEST(VibrationMeter, NoticesAnEngineThatStartsAndOneThatStops) {
  Shaken sensor;
  sensor.run(3.0, 0.5);
  EXPECT_GT(sensor.added_gyro(sensor.run(0.5, 20.0)), 100.0);
  sensor.run(3.0, 20.0);
  EXPECT_LT(sensor.added_gyro(sensor.run(4.0, 0.5)), 1.0);
}

TEST(VibrationMeter, FastShakingThatIntegratesToNothingCountsLess) {
  // As rotors do it: hundreds of times the stated variance, near half the rate of the sensor.
  Shaken quiet;
  Shaken shaken;
  ImuNoise noise;
  const double amplitude = 20.0 * noise.gyro_noise_density * std::sqrt(200.0);
  ImuSample said;
  for (int i = 0; i < 1000; ++i) {
    ImuSample sample = quiet.sample(0.5);
    sample.angular_velocity.array() += amplitude * std::sin(2.0 * M_PI * 97.0 * i / 200.0);
    said = shaken.add(sample);
  }
  EXPECT_LT(shaken.added_gyro(said), 5.0);
  // White noise of that strength does not average out.
  Shaken noisy;
  EXPECT_GT(noisy.added_gyro(noisy.run(3.0, 20.0 / std::sqrt(2.0))), 100.0);
}

TEST(VibrationMeter, OneWrongReadingIsNoVibration) {
  Shaken sensor;
  sensor.run(3.0, 0.5);
  ImuSample wrong = sensor.sample(0.5);
  wrong.angular_velocity.setConstant(20.0);
  sensor.add(wrong);
  EXPECT_LT(sensor.added_gyro(sensor.run(0.05, 0.5)), 3.0);
}

TEST(VibrationMeter, GapsAndBrokenReadingsTellNothing) {
  Shaken sensor;
  sensor.run(3.0, 0.5);
  for (int i = 0; i < 20; ++i) {
    ImuSample broken = sensor.sample(0.5);
    broken.linear_acceleration.x() = std::numeric_limits<double>::quiet_NaN();
    ImuSample saturated = sensor.sample(0.5);
    saturated.angular_velocity.y() = 1e3;
    const ImuSample of_broken = sensor.add(broken);
    EXPECT_EQ(of_broken.gyro_variance, Eigen::Vector3d::Zero());
    EXPECT_EQ(sensor.add(saturated).accel_variance, Eigen::Vector3d::Zero());
    EXPECT_EQ(sensor.added_gyro(sensor.run(0.1, 0.5)), 0.0);
    sensor.skip(0.15);  // the wave is elsewhere after it
    EXPECT_EQ(sensor.added_gyro(sensor.run(0.1, 0.5)), 0.0);
  }
}

}  // namespace
}  // namespace imslam::imu
