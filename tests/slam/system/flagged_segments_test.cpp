#include "slam/system/flagged_segments.hpp"

#include <gtest/gtest.h>

#include "slam/system/conflicts.hpp"

namespace imslam::system {
namespace {

TEST(FlaggedSegments, AreTheLongestStretchesOfEachKind) {
  FrameSeries series;
  series.inliers = {0, 50, 0, 0, 50, 0};
  series.degraded = {0, 0, 0, 1, 0, 0};
  series.imu_gap = {0, 1, 1, 0, 0, 1};
  const auto segments = flagged_segments(series);
  ASSERT_EQ(segments.size(), 5U);
  const auto expect = [&](std::size_t i, const char* kind, std::size_t first, std::size_t last) {
    EXPECT_STREQ(segments[i].kind, kind);
    EXPECT_EQ(segments[i].first, first);
    EXPECT_EQ(segments[i].last, last);
  };
  expect(0, "degraded", 3, 3);
  expect(1, "imu_gap", 1, 2);
  expect(2, "imu_gap", 5, 5);
  expect(3, "no_vision", 2, 3);
  expect(4, "no_vision", 5, 5);
}

TEST(FlaggedSegments, OfAGoodRunAreNone) {
  FrameSeries series;
  series.inliers = {0, 50, 60};
  series.degraded = {0, 0, 0};
  EXPECT_TRUE(flagged_segments(series).empty());
}

/// Three frames; the gyro turns by `per_interval` in each interval, vision by `seen` over both.
std::vector<bool> conflicts(const Eigen::Vector3d& per_interval,
                            const Eigen::Vector3d& seen,
                            bool degraded = false) {
  Measurements measurements;
  measurements.times_ns = {0, 50, 100};
  RelativeMotion motion;
  motion.time1_ns = 100;
  motion.T_body0_body1 = {lie::SO3d::exp(seen), Eigen::Vector3d::Zero()};
  motion.covariance *= 1e-8;
  motion.valid = true;
  measurements.odometry = {motion};
  std::vector<ImuMotion> inertial(2);
  for (ImuMotion& each : inertial) {
    each.dR = lie::SO3d::exp(per_interval);
    each.covariance *= 1e-8;
    each.valid = true;
    each.degraded = degraded;
  }
  return rotation_conflicts(measurements, inertial);
}

TEST(RotationConflicts, AreSeenWhereVisionTurnsTheOtherWay) {
  const Eigen::Vector3d turn(0.01, 0.0, 0.02);
  EXPECT_EQ(conflicts(turn, 2.0 * turn), (std::vector<bool>{false, false, false}));
  EXPECT_EQ(conflicts(turn, -2.0 * turn), (std::vector<bool>{false, true, true}));
  EXPECT_EQ(conflicts(turn, -2.0 * turn, true), (std::vector<bool>{false, false, false}));
}

}  // namespace
}  // namespace imslam::system
