#include <gtest/gtest.h>

#include <cmath>

#include "datasets/simulation/imu_model.hpp"
#include "slam/base/config.hpp"
#include "slam/base/error.hpp"
#include "tests/support/numeric_jacobian.hpp"

namespace imslam::simulation {
namespace {

using testing::expect_near;

constexpr double kKnot_s = 0.1;

MotionSpline swaying(double duration_s) {
  std::vector<lie::SE3d> poses;
  for (std::size_t k = 0; k < MotionSpline::control_count(kKnot_s, duration_s); ++k) {
    const double t = MotionSpline::control_time(kKnot_s, k);
    const Eigen::Vector3d wave(0.5 * std::sin(t), 0.7 * std::sin(1.7 * t), t);
    poses.emplace_back(lie::SO3d::exp(wave), Eigen::Vector3d(std::sin(2.0 * t), 0.0, 0.0));
  }
  return MotionSpline(kKnot_s, poses);
}

ImuOptions without_errors() {
  ImuOptions options;
  options.grade = "mems";
  options.noise_scale = 0.0;
  options.bias_scale = 0.0;
  options.shape_scale = 0.0;
  return options;
}

TEST(ImuErrors, NewErrorsAreOffByDefaultAndChangeNoOtherDraw) {
  ImuOptions options;
  options.grade = "mems";
  const ImuErrors plain = draw_imu_errors(options, Random(4));
  EXPECT_TRUE(plain.g_sensitivity.isZero(0.0));
  EXPECT_TRUE(plain.drift.gyro.isZero(0.0));
  EXPECT_TRUE(plain.drift.accel.isZero(0.0));
  EXPECT_EQ(plain.vibration, 0.0);

  options.g_sensitivity_scale = options.temperature_scale = options.vibration = 1.0;
  const ImuErrors all = draw_imu_errors(options, Random(4));
  EXPECT_EQ(all.initial_bias.gyro, plain.initial_bias.gyro);
  EXPECT_EQ(all.gyro_shape, plain.gyro_shape);
  EXPECT_EQ(all.accel_shape, plain.accel_shape);

  // Nor any reading: what is added is what the new errors say, on the same noise.
  const MotionSpline motion = swaying(5.0);
  ImuModel plain_imu(plain, motion, 0, Random(2));
  ImuModel imu(all, motion, 0, Random(2));
  for (int i = 0; i < 200; ++i) {
    const SimulatedImuSample expected = plain_imu.next();
    const SimulatedImuSample sample = imu.next();
    const ImuBias drift{sample.bias.gyro - expected.bias.gyro,
                        sample.bias.accel - expected.bias.accel};
    expect_near(sample.reading.angular_velocity,
                expected.reading.angular_velocity + drift.gyro +
                    all.g_sensitivity * specific_force(sample.truth),
                1e-12);
    expect_near(sample.reading.linear_acceleration,
                expected.reading.linear_acceleration + drift.accel, 1e-12);
  }
}

TEST(ImuErrors, TheGyroFeelsForcesAsMuchAsItsGradeSays) {
  double sum = 0.0;
  ImuOptions options = without_errors();
  options.g_sensitivity_scale = 2.0;
  for (std::uint64_t seed = 0; seed < 100; ++seed) {
    sum += draw_imu_errors(options, Random(seed)).g_sensitivity.squaredNorm();
  }
  const double degree_per_g = M_PI / 180.0 / kGravity;
  EXPECT_NEAR(std::sqrt(sum / 900.0), 2.0 * 0.1 * degree_per_g, 0.02 * degree_per_g);
}

TEST(ImuErrors, TheBiasDriftsTowardsItsWarmValueAndTheTruthSaysSo) {
  const MotionSpline motion = swaying(200.0);
  ImuOptions options = without_errors();
  options.rate_hz = 50.0;
  options.temperature_scale = 1.0;
  const ImuErrors errors = draw_imu_errors(options, Random(4));
  EXPECT_GT(errors.drift.gyro.norm(), 1e-3);
  EXPECT_GE(errors.drift_time_s, 30.0);
  EXPECT_LE(errors.drift_time_s, 300.0);
  ImuModel imu(errors, motion, 0, Random(2));
  for (int i = 0; i <= 10000; ++i) {
    const SimulatedImuSample sample = imu.next();
    if (i % 1000 != 0) continue;
    const double share = 1.0 - std::exp(-sample.time_s / errors.drift_time_s);
    expect_near(sample.bias.gyro, share * errors.drift.gyro, 1e-15);
    expect_near(sample.reading.angular_velocity, sample.truth.omega_body + sample.bias.gyro, 1e-12);
    expect_near(sample.reading.linear_acceleration,
                specific_force(sample.truth) + share * errors.drift.accel, 1e-12);
  }
}

TEST(ImuErrors, VibrationComesWithItsLevelsOnly) {
  const MotionSpline motion = swaying(10.0);
  ImuOptions options = without_errors();
  options.vibration = 1.0;
  const ImuErrors errors = draw_imu_errors(options, Random(4));
  ImuModel imu(errors, motion, 0, Random(2), {{5.0, 0.0, 0.0}, {5.5, 1.0, 1.0}});
  ImuModel parked(errors, motion, 0, Random(2));
  double before = 0.0;
  double after = 0.0;
  for (int i = 0; i < 2000; ++i) {
    const SimulatedImuSample sample = imu.next();
    const Eigen::Vector3d added = sample.reading.linear_acceleration - specific_force(sample.truth);
    (i < 1000 ? before : after) += added.squaredNorm();
    const SimulatedImuSample quiet = parked.next();
    expect_near(quiet.reading.linear_acceleration, specific_force(quiet.truth), 1e-12);
  }
  EXPECT_LT(before, 1e-20);
  EXPECT_GT(std::sqrt(after / 3000.0), 0.2);
}

TEST(ImuErrors, APerfectSensorHasNone) {
  ImuOptions options;
  options.grade = "perfect";
  options.g_sensitivity_scale = options.temperature_scale = options.vibration = 1.0;
  const ImuErrors errors = draw_imu_errors(options, Random(4));
  EXPECT_TRUE(errors.g_sensitivity.isZero(0.0));
  EXPECT_TRUE(errors.drift.accel.isZero(0.0));
  EXPECT_EQ(errors.vibration, 0.0);
}

TEST(ImuErrors, OptionsOutOfBoundsAreRefused) {
  for (double ImuOptions::*field :
       {&ImuOptions::g_sensitivity_scale, &ImuOptions::temperature_scale, &ImuOptions::vibration}) {
    ImuOptions options;
    options.*field = -1.0;
    EXPECT_THROW(options.validate(), InputError);
    options.*field = std::nan("");
    EXPECT_THROW(options.validate(), InputError);
  }
}

}  // namespace
}  // namespace imslam::simulation
