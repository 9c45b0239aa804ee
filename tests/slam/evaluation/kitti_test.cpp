#include "slam/evaluation/kitti.hpp"

#include <gtest/gtest.h>

#include "slam/base/text.hpp"
#include "slam/evaluation/rigid_matrix.hpp"
#include "tests/slam/evaluation/paths.hpp"

namespace imslam::evaluation {
namespace {

using testing::disturbed;
using testing::winding_path;

PosePath straight(std::size_t poses, double step_m, double turn_per_pose_rad = 0.0) {
  PosePath path;
  Eigen::Matrix4d T = Eigen::Matrix4d::Identity();
  const Eigen::Matrix4d step =
      rigid(Eigen::AngleAxisd(turn_per_pose_rad, Eigen::Vector3d::UnitY()).toRotationMatrix(),
            {0, 0, step_m});
  for (std::size_t i = 0; i < poses; ++i, T = T * step) path.poses.push_back(T);
  return path;
}

TEST(KittiDrift, OfAScaledPathIsTheMissingShare) {
  const PosePath reference = straight(1001, 1.0);
  const PosePath estimate = straight(1001, 0.99);
  const Drift drift = kitti_drift(reference, estimate);
  // The end of a stretch lies strictly beyond its length: 101 poses for 100 m.
  EXPECT_NEAR(drift.by_length[0].t_percent, 1.01, 1e-9);
  EXPECT_NEAR(drift.r_rel_deg_per_100m, 0.0, 1e-9);
  // Starts every ten poses: 90 stretches of 100 m (0..890), ..., 20 of 800 m.
  EXPECT_EQ(drift.by_length[0].count, 90U);
  EXPECT_EQ(drift.by_length[7].count, 20U);
  EXPECT_EQ(drift.segments.size(), 90U + 80U + 70U + 60U + 50U + 40U + 30U + 20U);
  EXPECT_NEAR(drift.segments[0].speed_mps, 100.0 / (0.1 * 102), 1e-12);
}

TEST(KittiDrift, OfASteadyTurnIsItsAngle) {
  const double turn = 1e-4;
  const Drift drift = kitti_drift(straight(500, 1.0), straight(500, 1.0, turn));
  EXPECT_NEAR(drift.by_length[0].r_deg_per_100m, 101 * turn * kDegreesPerRadian, 1e-7);
}

TEST(KittiDrift, HasNoSegmentsOnShortPaths) {
  const Drift drift = kitti_drift(straight(80, 0.8), straight(80, 0.8));
  EXPECT_TRUE(drift.segments.empty());
  EXPECT_TRUE(drift.by_length.empty());
}

TEST(KittiDrift, ShowsBandsOfSpeed) {
  const Drift drift = kitti_drift(straight(1001, 1.0), straight(1001, 0.99));  // about 9.8 m/s
  ASSERT_EQ(drift.by_speed.size(), 2U);
  EXPECT_EQ(drift.by_speed[0].key, 8.0);
  EXPECT_EQ(drift.by_speed[1].key, 10.0);
  EXPECT_EQ(drift.by_speed[0].count, drift.segments.size());
}

TEST(SubTrajectoryDrift, MeasuresShortPaths) {
  const Drift drift = sub_trajectory_drift(straight(101, 0.1), straight(101, 0.099));
  ASSERT_EQ(drift.by_length.size(), 5U);
  EXPECT_NEAR(drift.by_length[0].key, 1.0, 1e-9);
  EXPECT_NEAR(drift.by_length[4].key, 5.0, 1e-9);
  EXPECT_NEAR(drift.t_rel_percent, 1.03, 0.05);
  EXPECT_TRUE(sub_trajectory_drift(straight(5, 0.0), straight(5, 0.0)).segments.empty());
}

TEST(DevkitErrors, AreOneLinePerSegment) {
  const Drift drift = kitti_drift(straight(201, 1.0), straight(201, 0.99));
  const std::string text = devkit_errors(drift);
  const auto lines = split(text, '\n');
  ASSERT_EQ(lines.size(), drift.segments.size() + 1);
  EXPECT_EQ(lines[1], "10 0.000000 0.010100 100.000000 9.803922");
}

}  // namespace
}  // namespace imslam::evaluation
