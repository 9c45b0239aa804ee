#include "slam/evaluation/motion_consistency.hpp"

#include <gtest/gtest.h>

#include <Eigen/Cholesky>

#include "slam/base/random.hpp"
#include "slam/base/time.hpp"

namespace imslam::evaluation {
namespace {

constexpr int kSteps = 4000;

Eigen::Matrix<double, 6, 6> covariance() {
  Eigen::Matrix<double, 6, 6> root = Eigen::Matrix<double, 6, 6>::Zero();
  for (int i = 0; i < 6; ++i) {
    for (int j = 0; j <= i; ++j) root(i, j) = i == j ? 1e-3 * (1 + i) : 2e-4 * (i - j);
  }
  return root * root.transpose();
}

struct World {
  PosePath truth;
  lie::SE3d T_body_truth =
      lie::SE3d::exp((Eigen::Matrix<double, 6, 1>() << 0.1, 0.2, -0.1, 0.3, -0.2, 0.4).finished());
  std::vector<RelativeMotion> motions;
};

/// Motions with errors of `scale` times the stated standard deviation.
World make_world(double scale) {
  World world;
  Random random(3);
  const Eigen::Matrix<double, 6, 6> root = covariance().llt().matrixL();
  lie::SE3d T_world_body;
  for (int i = 0; i <= kSteps; ++i) {
    world.truth.stamps_s.push_back(0.05 * i);
    world.truth.poses.push_back((T_world_body * world.T_body_truth).matrix());
    Eigen::Matrix<double, 6, 1> step;
    Eigen::Matrix<double, 6, 1> error;
    for (int k = 0; k < 6; ++k) step(k) = 0.05 * random.normal();
    for (int k = 0; k < 6; ++k) error(k) = scale * random.normal();
    const lie::SE3d T_body0_body1 = lie::SE3d::exp(step);
    RelativeMotion motion;
    motion.time0_ns = static_cast<std::int64_t>(0.05 * kNanosecondsPerSecond) * i;
    motion.time1_ns = static_cast<std::int64_t>(0.05 * kNanosecondsPerSecond) * (i + 1);
    motion.T_body0_body1 = T_body0_body1 * lie::SE3d::exp(root * error).inverse();
    motion.covariance = covariance();
    motion.valid = true;
    if (i < kSteps) world.motions.push_back(motion);
    T_world_body = T_world_body * T_body0_body1;
  }
  return world;
}

TEST(MotionConsistency, OfRightCovariancesIsIdeal) {
  const World world = make_world(1.0);
  const auto c = motion_consistency(world.motions, world.truth, world.T_body_truth);
  ASSERT_TRUE(c.has_value());
  EXPECT_EQ(c->motions, static_cast<std::size_t>(kSteps));
  EXPECT_NEAR(c->nees_mean, 6.0, 0.25);
  EXPECT_NEAR(c->nees_median, 5.35, 0.25);
  EXPECT_NEAR(c->nees_translation_mean, 3.0, 0.2);
  EXPECT_NEAR(c->nees_rotation_mean, 3.0, 0.2);
  EXPECT_NEAR(c->share_inside, 0.95, 0.015);
}

TEST(MotionConsistency, FindsOverconfidence) {
  const World world = make_world(2.0);
  const auto c = motion_consistency(world.motions, world.truth, world.T_body_truth);
  ASSERT_TRUE(c.has_value());
  EXPECT_NEAR(c->nees_mean, 24.0, 1.0);
  EXPECT_LT(c->share_inside, 0.4);
}

TEST(MotionConsistency, MotionsWithoutTruthDoNotCount) {
  World world = make_world(1.0);
  world.motions[0].time0_ns += 2'000'000;  // 2 ms off
  world.motions[1].valid = false;
  const auto c = motion_consistency(world.motions, world.truth, world.T_body_truth);
  ASSERT_TRUE(c.has_value());
  EXPECT_EQ(c->motions, static_cast<std::size_t>(kSteps - 2));
  EXPECT_FALSE(motion_consistency({}, world.truth, world.T_body_truth).has_value());
}

}  // namespace
}  // namespace imslam::evaluation
