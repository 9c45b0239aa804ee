#include "vo_net/pose_consensus.hpp"

#include <gtest/gtest.h>

#include "tests/vo_net/synthetic_points.hpp"
#include "vo_net/pose_layer.hpp"

namespace imslam::vo {
namespace {

using testing::synthetic_correspondences;
using testing::test_camera;
using testing::test_motion;

/// `still` points of the scene and ten things of `each` points that go their own ways.
Correspondences crowd(int still, int each, std::uint64_t seed) {
  Random random(seed);
  const StereoCamera camera = test_camera();
  const testing::PointNoise noise{0.1, 0.1, 0.0};
  Correspondences all = synthetic_correspondences(camera, test_motion(), still, noise, random);
  for (int thing = 0; thing < 10; ++thing) {
    lie::SE3d::Tangent own;
    for (int i = 0; i < 6; ++i) own(i) = (i < 3 ? 0.15 : 0.04) * random.normal();
    const Correspondences moving =
        synthetic_correspondences(camera, test_motion() * lie::SE3d::exp(own), each, noise, random);
    all.insert(all.end(), moving.begin(), moving.end());
  }
  return all;
}

double error(const PoseLayerResult& result) {
  return (result.T_body0_body1.inverse() * test_motion()).log().norm();
}

TEST(PoseConsensus, FindsTheMotionOfTheLargestGroupAmongMany) {
  for (std::uint64_t seed = 1; seed <= 20; ++seed) {
    const Correspondences c = crowd(160, 24, seed);  // 40 % stand still
    const PoseLayerResult result = solve_pose(c, test_camera(), {});
    ASSERT_TRUE(result.valid) << seed;
    EXPECT_LT(error(result), 0.005) << seed;
    EXPECT_GT(result.inliers, 120) << seed;
  }
}

TEST(PoseConsensus, WithoutItThatMotionIsLost) {
  PoseLayerOptions options;
  options.consensus_share = 0.0;
  int lost = 0;
  for (std::uint64_t seed = 1; seed <= 20; ++seed) {
    const PoseLayerResult result = solve_pose(crowd(160, 24, seed), test_camera(), options);
    lost += result.valid && error(result) < 0.005 ? 0 : 1;
  }
  EXPECT_GT(lost, 5);
}

TEST(PoseConsensus, ChangesNothingWhereMostPointsAgree) {
  const Correspondences c = crowd(400, 10, 3);
  PoseLayerOptions without;
  without.consensus_share = 0.0;
  const PoseLayerResult a = solve_pose(c, test_camera(), {});
  const PoseLayerResult b = solve_pose(c, test_camera(), without);
  EXPECT_EQ(a.T_body0_body1.matrix(), b.T_body0_body1.matrix());
  EXPECT_EQ(a.covariance, b.covariance);
}

TEST(PoseConsensus, PointsWithNothingInCommonGiveNoConfidentMotion) {
  Random random(5);
  Correspondences c = crowd(200, 0, 5);
  for (Correspondence& one : c) {
    one.left1 += 60.0 * Eigen::Vector2d{random.normal(), random.normal()};
    one.disparity1 = random.uniform(1.0, 60.0);
  }
  const PoseLayerResult result = solve_pose(c, test_camera(), {});
  EXPECT_FALSE(result.valid && result.inliers > 40);
}

TEST(PoseConsensus, IsTheSameEveryTime) {
  const Correspondences c = crowd(160, 24, 7);
  const PoseLayerResult a = solve_pose(c, test_camera(), {});
  const PoseLayerResult b = solve_pose(c, test_camera(), {});
  EXPECT_EQ(a.T_body0_body1.matrix(), b.T_body0_body1.matrix());
}

/// As a gyro would say it, half a standard deviation off.
ForetoldMotion foretold_rotation() {
  ForetoldMotion foretold;
  const lie::SE3d motion = test_motion();
  foretold.R_body0_body1 = motion.rotation() * lie::SO3d::exp({1e-3, 0.0, 0.0});
  foretold.sigma_rad = 2e-3;
  return foretold;
}

/// Points that stay where they are in all images.
Correspondences dirt(int count, std::uint64_t seed) {
  Random random(seed);
  return synthetic_correspondences(test_camera(), lie::SE3d(), count, {0.1, 0.1, 0.0}, random);
}

TEST(PoseConsensus, AForetoldRotationFindsTheSceneBehindManyThings) {
  int lost = 0;
  for (std::uint64_t seed = 1; seed <= 20; ++seed) {
    const Correspondences c = crowd(100, 30, seed);  // a quarter stands still
    const PoseLayerResult blind = solve_pose(c, test_camera(), {});
    lost += blind.valid && error(blind) < 0.01 ? 0 : 1;
    const PoseLayerResult result =
        solve_pose(c, test_camera(), {}, lie::SE3d(), 0.0, foretold_rotation());
    ASSERT_TRUE(result.valid) << seed;
    EXPECT_LT(error(result), 0.01) << seed;
  }
  EXPECT_GT(lost, 5) << "too easy";
}

TEST(PoseConsensus, DirtOnTheLensDoesNotPassForTheScene) {
  for (std::uint64_t seed = 1; seed <= 10; ++seed) {
    Correspondences c = crowd(120, 0, seed);
    const Correspondences stuck = dirt(280, seed);
    c.insert(c.end(), stuck.begin(), stuck.end());
    EXPECT_LT(solve_pose(c, test_camera(), {}).T_body0_body1.log().norm(), 0.01) << "captured";
    const PoseLayerResult result =
        solve_pose(c, test_camera(), {}, lie::SE3d(), 0.0, foretold_rotation());
    ASSERT_TRUE(result.valid) << seed;
    EXPECT_LT(error(result), 0.01) << seed;
  }
}

TEST(PoseConsensus, AWrongForetoldTranslationDoesNotBeatTheMajority) {
  Correspondences c = crowd(300, 0, 3);
  const lie::SE3d motion = test_motion();
  const lie::SE3d other(motion.rotation(), Eigen::Vector3d(0.3, -0.2, 0.1));
  Random random(9);
  const Correspondences few =
      synthetic_correspondences(test_camera(), other, 100, {0.1, 0.1, 0.0}, random);
  c.insert(c.end(), few.begin(), few.end());
  ForetoldMotion foretold = foretold_rotation();
  foretold.p_body0_body1 = other.translation();
  foretold.sigma_m = 0.01;
  const PoseLayerResult result = solve_pose(c, test_camera(), {}, lie::SE3d(), 0.0, foretold);
  ASSERT_TRUE(result.valid);
  EXPECT_LT(error(result), 0.005);
}

TEST(PoseConsensus, WhatWasForetoldDoesNotBendTheResult) {
  const Correspondences c = crowd(400, 4, 3);
  const PoseLayerResult a = solve_pose(c, test_camera(), {});
  const PoseLayerResult b = solve_pose(c, test_camera(), {}, lie::SE3d(), 0.0, foretold_rotation());
  EXPECT_EQ(a.T_body0_body1.matrix(), b.T_body0_body1.matrix());
}

}  // namespace
}  // namespace imslam::vo
