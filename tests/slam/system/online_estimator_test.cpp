#include "slam/system/online_estimator.hpp"

#include <gtest/gtest.h>

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
    online.update(so_far, {});
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
