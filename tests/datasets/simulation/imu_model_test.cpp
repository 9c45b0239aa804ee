#include "datasets/simulation/imu_model.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "datasets/simulation/motion.hpp"
#include "tests/support/numeric_jacobian.hpp"

namespace imslam::simulation {
namespace {

using testing::expect_near;

lie::SE3d loop(double t) {
  const Eigen::Vector3d wave(0.3 * std::sin(1.1 * t), 0.2 * std::cos(1.7 * t), 0.6 * t);
  return lie::SE3d(lie::SO3d::exp(wave),
                   {2 * std::cos(0.6 * t), std::sin(0.8 * t), 1 + 0.3 * std::sin(t)});
}

MotionSpline motion_of(const std::string& name, double duration_s) {
  SimulationOptions options;
  options.motion = name;
  options.duration_s = duration_s;
  options.rest_s = 0.5;
  return make_motion(options, loop);
}

TEST(ImuModel, PerfectReadingsIntegrateToTheTruth) {
  const MotionSpline motion = motion_of("natural", 10.0);
  ImuOptions options;
  options.grade = "perfect";
  options.rate_hz = 1000.0;
  ImuModel imu(draw_imu_errors(options, Random(1)), motion, 0, Random(2));
  SimulatedImuSample last = imu.next();
  lie::SO3d R = last.truth.T_world_body.rotation();
  Eigen::Vector3d p = last.truth.T_world_body.translation();
  Eigen::Vector3d v = last.truth.v_world;
  const Eigen::Vector3d g(0, 0, -kGravity);
  const double dt = 1e-3;
  for (int i = 0; i < 10000; ++i) {  // midpoint rule
    const SimulatedImuSample next = imu.next();
    const Eigen::Vector3d omega =
        0.5 * (last.reading.angular_velocity + next.reading.angular_velocity);
    const lie::SO3d R_next = R * lie::SO3d::exp(omega * dt);
    const Eigen::Vector3d a =
        0.5 * (R * last.reading.linear_acceleration + R_next * next.reading.linear_acceleration) +
        g;
    p += v * dt + 0.5 * a * dt * dt;
    v += a * dt;
    R = R_next;
    last = next;
  }
  const MotionState& truth = last.truth;
  EXPECT_LT((truth.T_world_body.rotation().inverse() * R).log().norm(), 2e-6);
  EXPECT_LT((truth.v_world - v).norm(), 2e-5);
  EXPECT_LT((truth.T_world_body.translation() - p).norm(), 1e-4);
}

TEST(ImuModel, ReadsGravityUpwardsAtRest) {
  const MotionSpline motion = motion_of("static", 1.0);
  ImuOptions options;
  options.grade = "perfect";
  ImuModel imu(draw_imu_errors(options, Random(1)), motion, 100, Random(2));
  const SimulatedImuSample sample = imu.next();
  const Eigen::Vector3d up =
      sample.truth.T_world_body.rotation().inverse() * Eigen::Vector3d::UnitZ();
  expect_near(sample.reading.linear_acceleration, 9.81 * up, 1e-9);
  EXPECT_EQ(sample.reading.time_ns, 100);
  EXPECT_EQ(imu.next().reading.time_ns, 100 + 5'000'000);
}

TEST(ImuModel, NoiseAndBiasWalkHaveTheDensitiesOfTheDataSheet) {
  constexpr int kCount = 40000;
  const MotionSpline motion = motion_of("static", 200.0);
  ImuOptions options;
  options.grade = "mems";
  options.shape_scale = 0.0;
  const ImuErrors errors = draw_imu_errors(options, Random(1));
  ImuModel imu(errors, motion, 0, Random(7));
  double gyro_noise = 0.0;
  double gyro_walk = 0.0;
  double accel_walk = 0.0;
  ImuBias last = errors.initial_bias;
  for (int i = 0; i < kCount; ++i) {
    const SimulatedImuSample sample = imu.next();
    gyro_noise += (sample.reading.angular_velocity - sample.truth.omega_body - sample.bias.gyro)
                      .squaredNorm();
    gyro_walk += (sample.bias.gyro - last.gyro).squaredNorm();
    accel_walk += (sample.bias.accel - last.accel).squaredNorm();
    last = sample.bias;
  }
  const double rate = errors.noise.rate_hz;
  // Of 120 000 values: the estimate of a sigma is good to 0.2 %.
  EXPECT_NEAR(std::sqrt(gyro_noise / (3 * kCount)),
              errors.noise.gyro_noise_density * std::sqrt(rate),
              0.01 * errors.noise.gyro_noise_density * std::sqrt(rate));
  EXPECT_NEAR(std::sqrt(gyro_walk / (3 * kCount)), errors.noise.gyro_random_walk / std::sqrt(rate),
              0.01 * errors.noise.gyro_random_walk / std::sqrt(rate));
  EXPECT_NEAR(std::sqrt(accel_walk / (3 * kCount)),
              errors.noise.accel_random_walk / std::sqrt(rate),
              0.01 * errors.noise.accel_random_walk / std::sqrt(rate));
}

TEST(ImuModel, SaturatesAndQuantises) {
  const MotionSpline motion = motion_of("natural", 5.0);
  ImuOptions options;
  options.gyro_range = 0.2;
  options.accel_range = 10.0;
  options.quantise = true;
  const ImuErrors errors = draw_imu_errors(options, Random(1));
  ImuModel imu(errors, motion, 0, Random(2));
  int saturated = 0;
  for (int i = 0; i < 1000; ++i) {
    const ImuSample reading = imu.next().reading;
    EXPECT_LE(reading.angular_velocity.cwiseAbs().maxCoeff(), 0.2 + 1e-12);
    EXPECT_LE(reading.linear_acceleration.cwiseAbs().maxCoeff(), 10.0 + 1e-12);
    saturated += reading.angular_velocity.cwiseAbs().maxCoeff() > 0.2 - 1e-9 ? 1 : 0;
    const double steps = reading.linear_acceleration.x() / errors.accel_step;
    EXPECT_NEAR(steps, std::round(steps), 1e-6);
  }
  EXPECT_GT(saturated, 100);
}

TEST(ImuModel, ScaleAndMisalignmentActOnTheTrueMotion) {
  ImuOptions options;
  options.grade = "phone";
  options.noise_scale = 0.0;
  options.bias_scale = 0.0;
  const MotionSpline motion = motion_of("natural", 5.0);
  const ImuErrors errors = draw_imu_errors(options, Random(4));
  EXPECT_GT((errors.gyro_shape - Eigen::Matrix3d::Identity()).norm(), 1e-3);
  EXPECT_GT(errors.data_sheet.gyro_noise_density, 0.0);  // an estimator divides by it
  ImuModel imu(errors, motion, 0, Random(2));
  for (int i = 0; i < 400; ++i) imu.next();
  const SimulatedImuSample sample = imu.next();
  expect_near(sample.reading.angular_velocity, errors.gyro_shape * sample.truth.omega_body, 1e-12);
}

}  // namespace
}  // namespace imslam::simulation
