#include "slam/system/inertial_start.hpp"

#include <gtest/gtest.h>

#include "slam/base/random.hpp"
#include "slam/base/time.hpp"
#include "tests/slam/system/sine_measurements.hpp"
#include "tests/support/numeric_jacobian.hpp"

namespace imslam::system {
namespace {

using imslam::testing::expect_near;

const Eigen::Vector3d kGyroBias(0.01, -0.02, 0.05);

/// Four frames in the dark; the IMU lies tilted on a table, or is waved about.
Measurements blind(bool at_rest) {
  Measurements measurements;
  for (int k = 0; k < 4; ++k) measurements.times_ns.push_back(to_nanoseconds(0.3 * k));
  const lie::SO3d R_world_body = lie::SO3d::exp({0.3, -0.2, 0.0});
  Random random(1);
  for (int i = -20; i < 400; ++i) {
    ImuSample sample;
    const double t = 0.005 * i;
    sample.time_ns = to_nanoseconds(t);
    sample.angular_velocity = kGyroBias + 1e-3 * random.normal3();
    if (!at_rest) sample.angular_velocity.x() += std::sin(5.0 * t);
    sample.linear_acceleration =
        R_world_body.inverse() * Eigen::Vector3d(0.0, 0.0, 9.81) + 0.02 * random.normal3();
    measurements.imu.push_back(sample);
  }
  return measurements;
}

InertialStart start_of(const Measurements& measurements) {
  return start_inertial(measurements, chain_odometry(measurements), SlamOptions());
}

TEST(InertialStart, WithoutVisionRestTellsAttitudeAndGyroBias) {
  const InertialStart start = start_of(blind(true));
  ASSERT_EQ(start.states.size(), 4U);
  const Eigen::Vector3d up_body =
      start.states[0].nav.T_world_body.rotation().inverse() * Eigen::Vector3d::UnitZ();
  const Eigen::Vector3d expected =
      lie::SO3d::exp({0.3, -0.2, 0.0}).inverse() * Eigen::Vector3d::UnitZ();
  expect_near(up_body, expected, 1e-3);
  expect_near(start.states[0].bias.gyro, kGyroBias, 3e-4);
  expect_near(start.inertial[0].bias.gyro, kGyroBias, 3e-4);
}

TEST(InertialStart, WithoutVisionAndRestThereIsNone) {
  const InertialStart start = start_of(blind(false));
  EXPECT_TRUE(start.states.empty());
  EXPECT_FALSE(start.reason.empty());
}

TEST(InertialStart, ABeliefStandsInForVision) {
  Measurements measurements = blind(false);
  measurements.bias_beliefs.push_back({2, 0, 0.07, 1e-3});
  EXPECT_EQ(start_of(measurements).inertial[0].bias.gyro, Eigen::Vector3d(0.0, 0.0, 0.07));
}

/// Clocks that are further apart than the search reaches, and what is said to be expected of them.
InertialStart start_far_apart(bool estimate) {
  testing::SineWorld world;
  world.time_offset_s = 0.3;
  const Measurements measurements = world.measure();
  SlamOptions options;
  options.system.time_offset_s = 0.27;
  options.pgo.estimate_time_offset = estimate;
  return start_inertial(measurements, chain_odometry(measurements), options);
}

TEST(InertialStart, LooksForTheTimeOffsetAroundTheOneThatIsExpected) {
  const InertialStart start = start_far_apart(true);
  EXPECT_NEAR(start.time_offset_s, 0.3, 1e-3);
  EXPECT_FALSE(start.states.empty()) << start.reason;
}

TEST(InertialStart, TakesTheExpectedTimeOffsetWhereNoneIsEstimated) {
  const InertialStart start = start_far_apart(false);
  EXPECT_EQ(start.time_offset_s, 0.27);
  EXPECT_EQ(start.inertial[60].time_offset_s, 0.27);
}

}  // namespace
}  // namespace imslam::system
