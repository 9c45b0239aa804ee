#include "slam/system/online_estimator.hpp"

#include <gtest/gtest.h>

#include <algorithm>

#include "slam/base/random.hpp"
#include "tests/slam/system/sine_measurements.hpp"

namespace imslam::system {
namespace {

using testing::SineWorld;

/// Hands over a recording frame by frame, as the SLAM loop does.
void stream(const Measurements& all, OnlineEstimator& online) {
  Measurements so_far;
  so_far.imu = all.imu;
  so_far.imu_noise = all.imu_noise;
  auto motion = all.odometry.begin();
  for (const std::int64_t time_ns : all.times_ns) {
    so_far.times_ns.push_back(time_ns);
    for (; motion != all.odometry.end() && motion->time1_ns <= time_ns; ++motion) {
      so_far.odometry.push_back(*motion);
    }
    online.update(so_far, [] { return Estimate{0.0, 2.0}; });
  }
}

TEST(OnlineEstimator, FollowsThePerfectlyMeasuredTruth) {
  const SineWorld world;
  OnlineEstimator online{SlamOptions()};
  const Measurements all = world.measure();
  stream(all, online);
  ASSERT_EQ(online.trajectory().size(), all.times_ns.size());
  EXPECT_LT(world.largest_error(online.trajectory()), 0.01);
}

TEST(OnlineEstimator, SurvivesHolesInVisionAndImu) {
  const SineWorld world;
  Measurements all = world.measure();
  all.odometry.erase(all.odometry.begin() + 60, all.odometry.begin() + 70);
  all.imu.erase(all.imu.begin() + 900, all.imu.begin() + 1000);
  OnlineEstimator online{SlamOptions()};
  stream(all, online);
  ASSERT_EQ(online.trajectory().size(), all.times_ns.size());
  for (const lie::SE3d& pose : online.trajectory().poses) {
    EXPECT_TRUE(pose.matrix().allFinite());
  }
  EXPECT_LT(world.largest_error(online.trajectory()), 0.1);
}

/// As if something that turns by itself filled the images for a while.
void turn_vision(Measurements& measurements, std::size_t from, std::size_t to) {
  for (std::size_t i = from; i < to; ++i) {
    lie::SE3d& T = measurements.odometry[i].T_body0_body1;
    T = T * lie::SE3d(lie::SO3d::exp({0.0, 0.08, 0.0}), {0.05, 0.0, 0.02});
  }
}

TEST(OnlineEstimator, LeavesOutMotionsThatTheGyroContradicts) {
  const SineWorld world;
  Measurements all = world.measure();
  turn_vision(all, 70, 75);
  OnlineEstimator online{SlamOptions()};
  stream(all, online);
  EXPECT_LT(world.largest_error(online.trajectory()), 0.05);  // 0.25 m were added
}

/// How far [m] two estimates of the same recording differ at a frame.
double apart(const OnlineEstimator& a, const OnlineEstimator& b, std::size_t frame) {
  return (a.trajectory().poses[frame].translation() - b.trajectory().poses[frame].translation())
      .norm();
}

TEST(OnlineEstimator, AGyroThatContradictsForSecondsIsNotBelieved) {
  const SineWorld world;
  Measurements all = world.measure();
  OnlineEstimator with_all{SlamOptions()};
  turn_vision(all, 60, all.odometry.size());
  stream(all, with_all);
  OnlineEstimator without{SlamOptions()};
  all.odometry.erase(all.odometry.begin() + 60, all.odometry.end());
  stream(all, without);
  ASSERT_EQ(with_all.trajectory().size(), all.times_ns.size());
  EXPECT_LT(apart(with_all, without, 95), 1e-6);   // refused
  EXPECT_GT(apart(with_all, without, 115), 1e-2);  // taken in after 2 s
}

TEST(OnlineEstimator, TheFirstContradictionAfterSecondsWithoutVisionIsRefused) {
  const SineWorld world;
  Measurements all = world.measure();
  turn_vision(all, 105, 110);
  Measurements blind = all;
  all.odometry.erase(all.odometry.begin() + 60, all.odometry.begin() + 105);
  blind.odometry.erase(blind.odometry.begin() + 60, blind.odometry.begin() + 110);
  OnlineEstimator with_all{SlamOptions()};
  stream(all, with_all);
  OnlineEstimator without{SlamOptions()};
  stream(blind, without);
  ASSERT_EQ(with_all.trajectory().size(), all.times_ns.size());
  EXPECT_LT(apart(with_all, without, 110), 1e-6);
}

// The IMU begins after 11 s, and is so noisy that it follows nothing without vision.
TEST(OnlineEstimator, StartsOnTheNewestFramesWhereTheFirstCannotStartIt) {
  SineWorld world;
  world.duration_s = 14.5;
  Measurements all = world.measure();
  all.imu.erase(all.imu.begin(), all.imu.begin() + 2300);
  all.imu_noise.accel_noise_density = 0.05;
  Random random(5);
  imu::testing::disturb(all.imu, {}, all.imu_noise, random);
  OnlineEstimator online{SlamOptions()};
  stream(all, online);
  const Trajectory& found = online.trajectory();
  ASSERT_GT(found.size(), 201U);  // it went on from there
  ASSERT_LT(found.size(), all.times_ns.size());
  EXPECT_TRUE(std::equal(found.times_ns.rbegin(), found.times_ns.rend(), all.times_ns.rbegin()));
  EXPECT_LT(world.largest_error(found), 0.1);  // the start is as tilted as the noise allows
}

TEST(OnlineEstimator, WithoutAnImuThereIsNothingToAdd) {
  const SineWorld world;
  Measurements all = world.measure();
  all.imu.clear();
  OnlineEstimator online{SlamOptions()};
  stream(all, online);
  EXPECT_EQ(online.trajectory().size(), 0U);
}

}  // namespace
}  // namespace imslam::system
