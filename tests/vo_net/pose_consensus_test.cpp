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

}  // namespace
}  // namespace imslam::vo
