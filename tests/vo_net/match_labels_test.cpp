#include "vo_net/match_labels.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "tests/vo_net/synthetic_points.hpp"

namespace imslam::vo {
namespace {

using nn::Index;

constexpr int kShrink = 2;
constexpr double kOffset_px = 0.3;

lie::SE3d seen_motion(const StereoCamera& camera, const lie::SE3d& T_body0_body1) {
  return camera.T_body_left.inverse() * T_body0_body1.inverse() * camera.T_body_left;
}

PoseLayerResult all_inliers(const Correspondences& points) {
  PoseLayerResult pose;
  pose.is_inlier.assign(points.size(), 1);
  return pose;
}

/// Points without noise, on a rectification that is off by kOffset_px.
Correspondences exact_points(const StereoCamera& camera, int count = 40) {
  Random random(8);
  return testing::synthetic_correspondences(camera, testing::test_motion(), count,
                                            {0.0, 0.0, kOffset_px}, random);
}

TEST(MatchLabels, AreTheMeasurementsThemselvesWhereTheyAgreeWithTheMotion) {
  const StereoCamera camera = testing::test_camera();
  const Correspondences points = exact_points(camera);
  const MatchLabels labels = match_labels(points, all_inliers(points), camera,
                                          testing::test_motion(), kOffset_px, kShrink);
  for (Index i = 0; i < static_cast<Index>(points.size()); ++i) {
    const Correspondence& c = points[static_cast<std::size_t>(i)];
    const Eigen::Vector2d flow = (c.left1 - c.left0) / kShrink;
    EXPECT_NEAR(labels.flow.displacement[2 * i], flow.x(), 1e-4);
    EXPECT_NEAR(labels.flow.displacement[2 * i + 1], flow.y(), 1e-4);
    EXPECT_NEAR(labels.stereo0.displacement[i], -c.disparity0 / kShrink, 1e-4);
    EXPECT_NEAR(labels.stereo1.displacement[i], -c.disparity1 / kShrink, 1e-4);
  }
}

/// Weighted squares of all four measurements of a point with true disparity d.
double misfit(const StereoCamera& camera,
              const lie::SE3d& T_left1_left0,
              const Correspondence& c,
              double d) {
  const Eigen::Vector3d at =
      camera.project(T_left1_left0 * camera.back_project({c.left0.x(), c.left0.y(), d}));
  const Eigen::Vector2d e = at.head<2>() - c.left1;
  return e.dot(c.flow_information * e) +
         c.disparity0_information * std::pow(d + kOffset_px - c.disparity0, 2) +
         c.disparity1_information * std::pow(at.z() + kOffset_px - c.disparity1, 2);
}

TEST(MatchLabels, TheDepthIsTheMostLikelyOneByAllFourMeasurements) {
  const StereoCamera camera = testing::test_camera();
  Random random(9);
  Correspondences points = testing::synthetic_correspondences(camera, testing::test_motion(), 40,
                                                              {0.5, 0.4, kOffset_px}, random);
  for (std::size_t i = 0; i < points.size(); ++i) {
    Correspondence& c = points[i];
    c.flow_information << 9.0, 2.0, 2.0, 3.0;
    if (i % 3 == 0) c.disparity1_information = 0.0;
  }
  const lie::SE3d T_left1_left0 = seen_motion(camera, testing::test_motion());
  const MatchLabels labels =
      match_labels(points, all_inliers(points), camera, testing::test_motion(), kOffset_px, 1, 4.0);
  for (std::size_t i = 0; i < points.size(); ++i) {
    const double d =
        -static_cast<double>(labels.stereo0.displacement[static_cast<Index>(i)]) - kOffset_px;
    const double least = misfit(camera, T_left1_left0, points[i], d);
    for (const double other : {d - 0.01, d + 0.01, 0.9 * d, 1.1 * d}) {
      EXPECT_LT(least, misfit(camera, T_left1_left0, points[i], other)) << i;
    }
  }
}

TEST(MatchLabels, AllThreeImagesShowOneAndTheSamePoint) {
  const StereoCamera camera = testing::test_camera();
  Random random(9);
  const Correspondences points = testing::synthetic_correspondences(
      camera, testing::test_motion(), 40, {0.5, 0.4, kOffset_px}, random);
  const lie::SE3d T_left1_left0 = seen_motion(camera, testing::test_motion());
  const MatchLabels labels = match_labels(points, all_inliers(points), camera,
                                          testing::test_motion(), kOffset_px, kShrink);
  for (Index i = 0; i < static_cast<Index>(points.size()); ++i) {
    const Eigen::Vector2d& left0 = points[static_cast<std::size_t>(i)].left0;
    const double d = -kShrink * static_cast<double>(labels.stereo0.displacement[i]) - kOffset_px;
    const Eigen::Vector3d at =
        camera.project(T_left1_left0 * camera.back_project({left0.x(), left0.y(), d}));
    EXPECT_NEAR(labels.flow.displacement[2 * i], (at.x() - left0.x()) / kShrink, 1e-3);
    EXPECT_NEAR(labels.flow.displacement[2 * i + 1], (at.y() - left0.y()) / kShrink, 1e-3);
    EXPECT_NEAR(labels.stereo1.displacement[i], -(at.z() + kOffset_px) / kShrink, 1e-3);
  }
}

TEST(MatchLabels, InliersAreRightFarOffOnesWrongAndInBetweenNobodyKnows) {
  const StereoCamera camera = testing::test_camera();
  Correspondences points = exact_points(camera, 3);
  // The depth is held by the disparity, so that the flow alone is off.
  for (Correspondence& c : points) c.disparity0_information = 1e6;
  points[1].left1.y() += 3.0;
  points[2].left1.y() += 5.0;
  PoseLayerResult pose = all_inliers(points);
  pose.is_inlier[1] = pose.is_inlier[2] = 0;
  const MatchLabels labels =
      match_labels(points, pose, camera, testing::test_motion(), kOffset_px, kShrink, 4.0);
  const float valid[] = {1.0F, 0.0F, 1.0F};
  const float seen[] = {1.0F, 0.0F, 0.0F};
  for (Index i = 0; i < 3; ++i) {
    EXPECT_EQ(labels.flow.valid[i], valid[i]) << i;
    EXPECT_EQ(labels.flow.visible[i], seen[i]) << i;
    // A wrong flow says nothing about the disparities.
    for (const MatchTruth<float>* stereo : {&labels.stereo0, &labels.stereo1}) {
      EXPECT_EQ(stereo->valid[i], seen[i]) << i;
      EXPECT_EQ(stereo->visible[i], seen[i]) << i;
    }
  }
}

TEST(MatchLabels, APointThatCannotBeFollowedCountsForNothing) {
  const StereoCamera camera = testing::test_camera();
  Correspondences points = exact_points(camera, 2);
  points[0].left1.x() = std::nan("");
  const MatchLabels labels = match_labels(points, all_inliers(points), camera,
                                          testing::test_motion(), kOffset_px, kShrink);
  for (const MatchTruth<float>* truth : {&labels.flow, &labels.stereo0, &labels.stereo1}) {
    EXPECT_EQ(truth->valid[0], 0.0F);
    EXPECT_EQ(truth->valid[1], 1.0F);
    EXPECT_TRUE(std::isfinite(truth->displacement[0]));
  }
}

}  // namespace
}  // namespace imslam::vo
