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

TEST(OnlineEstimator, AGyroThatContradictsForSecondsIsNotBelieved) {
  const SineWorld world;
  Measurements all = world.measure();
  OnlineEstimator with_all{SlamOptions()};
  turn_vision(all, 60, all.odometry.size());
  stream(all, with_all);
  OnlineEstimator without{SlamOptions()};
  all.odometry.erase(all.odometry.begin() + 60, all.odometry.end());
  stream(all, without);
  const auto apart = [&](std::size_t frame) {
    return (with_all.trajectory().poses[frame].translation() -
            without.trajectory().poses[frame].translation())
        .norm();
  };
  ASSERT_EQ(with_all.trajectory().size(), all.times_ns.size());
  EXPECT_LT(apart(95), 1e-6);   // refused
  EXPECT_GT(apart(115), 1e-2);  // taken in after 2 s
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
