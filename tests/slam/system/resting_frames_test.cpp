#include "slam/system/resting_frames.hpp"

#include <gtest/gtest.h>

#include <numeric>

#include "tests/imu_net/synthetic_motion.hpp"

namespace imslam::system {
namespace {

using imu::testing::stamp;

constexpr double kSigma = 0.01;  // [m/s] as system.zero_velocity_sigma
constexpr double kFrame_s = 0.05;

/// Frames in a row, and how far vision says that the body comes in each.
struct Stretch {
  int frames = 0;
  double step_m = 0.0;
};

/// What vision says of a step: it errs by less than it claims.
RelativeMotion step(int to, double step_m, Random& random) {
  RelativeMotion motion;
  motion.time0_ns = stamp((to - 1) * kFrame_s);
  motion.time1_ns = stamp(to * kFrame_s);
  const Eigen::Vector3d p = Eigen::Vector3d(step_m, 0.0, 0.0) + 1e-4 * random.normal3();
  motion.T_body0_body1 = {lie::SO3d(), p};
  motion.covariance.diagonal() << Eigen::Vector3d::Constant(2.25e-6),
      Eigen::Vector3d::Constant(1e-6);
  motion.valid = true;
  return motion;
}

/// The IMU reads gravity and noise, as it does at rest and on a smooth journey.
Measurements seen(const std::vector<Stretch>& stretches) {
  Random random(7);
  Measurements measurements;
  measurements.times_ns.push_back(stamp(0.0));
  for (const Stretch& stretch : stretches) {
    for (int i = 0; i < stretch.frames; ++i) {
      const auto to = static_cast<int>(measurements.times_ns.size());
      measurements.odometry.push_back(step(to, stretch.step_m, random));
      measurements.times_ns.push_back(stamp(to * kFrame_s));
    }
  }
  const auto readings = static_cast<int>(10 * measurements.times_ns.size());
  const lie::SO3d R_world_body = lie::SO3d::exp({0.3, -0.2, 0.0});
  for (int i = -100; i < readings + 100; ++i) {
    ImuSample sample;
    sample.time_ns = stamp(0.005 * i);
    sample.linear_acceleration = R_world_body.inverse() * Eigen::Vector3d(0.0, 0.0, 9.81);
    measurements.imu.push_back(sample);
  }
  imu::testing::disturb(measurements.imu, {}, measurements.imu_noise, random);
  return measurements;
}

std::vector<std::size_t> rests(const Measurements& measurements) {
  return resting_frames(measurements, kSigma, {});
}

std::vector<std::size_t> frames(std::size_t first, std::size_t last) {
  std::vector<std::size_t> all(last - first + 1);
  std::iota(all.begin(), all.end(), first);
  return all;
}

TEST(RestingFrames, OfARestAreAll) { EXPECT_EQ(rests(seen({{100, 0.0}})), frames(1, 100)); }

// 4 cm/s: no single step is longer than what a body at rest may seem to make.
TEST(RestingFrames, OfASmoothSlowJourneyAreNone) {
  EXPECT_TRUE(rests(seen({{100, 0.002}})).empty());
}

TEST(RestingFrames, OfARestShorterThanHalfASecondAreNone) {
  EXPECT_TRUE(rests(seen({{20, 0.01}, {9, 0.0}, {20, 0.01}})).empty());
  EXPECT_EQ(rests(seen({{20, 0.01}, {10, 0.0}, {20, 0.01}})), frames(21, 30));
}

// Judged in pieces of 2 s: a long rest must not lend its certainty to what follows.
TEST(RestingFrames, OfARestBeforeASlowJourneyAreThoseOfTheRest) {
  EXPECT_EQ(rests(seen({{60, 0.0}, {120, 0.002}})), frames(1, 40));
  for (const int rest : {70, 79}) {
    const auto resting = rests(seen({{rest, 0.0}, {120, 0.002}}));
    ASSERT_GE(resting.size(), 40U) << rest;
    EXPECT_EQ(std::vector<std::size_t>(resting.begin(), resting.begin() + 40), frames(1, 40));
    EXPECT_LE(resting.back(), 80U) << rest;  // the piece in which it sets off, at most
  }
}

TEST(RestingFrames, AreNoneWhereTheImuShakes) {
  Measurements measurements = seen({{60, 0.0}});
  Random random(3);
  for (ImuSample& sample : measurements.imu) {
    sample.angular_velocity += 0.2 * random.normal3();
  }
  EXPECT_TRUE(rests(measurements).empty());
}

TEST(RestingFrames, AreNotChainedOverAHoleInVision) {
  Measurements measurements = seen({{15, 0.0}});
  measurements.odometry.erase(measurements.odometry.begin() + 7);
  EXPECT_TRUE(rests(measurements).empty());  // 0.35 s on either side
}

}  // namespace
}  // namespace imslam::system
