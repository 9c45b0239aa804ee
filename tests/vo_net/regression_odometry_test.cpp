#include "vo_net/regression_odometry.hpp"

#include <gtest/gtest.h>

#include <Eigen/Eigenvalues>
#include <algorithm>

#include "slam/base/error.hpp"
#include "slam/nn/weights_io.hpp"
#include "tests/support/numeric_jacobian.hpp"
#include "tests/support/temp_dir.hpp"
#include "tests/vo_net/synthetic_points.hpp"
#include "vo_net/pose_head_weights.hpp"
#include "vo_net/visual_odometry.hpp"

namespace imslam::vo {
namespace {

using testing::PointNoise;

/// Points of a floor and a wavy wall: neighbours have like depths, as in the world (a network has
/// learned that), unlike those of synthetic_correspondences().
Correspondences room_points(const StereoCamera& camera,
                            const lie::SE3d& T_body0_body1,
                            double noise,
                            Random& random) {
  const lie::SE3d T_left1_left0 =
      camera.T_body_left.inverse() * T_body0_body1.inverse() * camera.T_body_left;
  Correspondences points;
  for (int v = 12; v < camera.height; v += 20) {
    for (int u = 12; u < camera.width; u += 20) {
      Correspondence c;
      c.left0 = {u + random.uniform(-8.0, 8.0), v + random.uniform(-8.0, 8.0)};
      const double wall = 0.2 + 0.05 * std::sin(0.01 * u);
      const double floor = (c.left0.y() - camera.cy) / camera.fy / 1.2;
      c.disparity0 = camera.fx * camera.baseline_m * std::max(wall, floor);
      const Eigen::Vector3d seen = camera.project(
          T_left1_left0 * camera.back_project({c.left0.x(), c.left0.y(), c.disparity0}));
      c.left1 = seen.head<2>() + noise * Eigen::Vector2d{random.normal(), random.normal()};
      c.disparity0 += noise * random.normal();
      c.disparity1 = seen.z() + noise * random.normal();
      c.flow_information = Eigen::Matrix2d::Identity() / 0.01;
      c.disparity0_information = c.disparity1_information = 1.0 / 0.01;
      points.push_back(c);
    }
  }
  return points;
}

PoseLayerResult solve(const Correspondences& points, const StereoCamera& camera) {
  static const TrainedPoseHead kShipped = load_pose_head("");
  return RegressionHead({}, kShipped.network).solve(points, camera, PoseLayerOptions());
}

struct Errors {
  double rotation = 0.0;     ///< [rad]
  double translation = 0.0;  ///< share of the length
};

Errors errors_of(const PoseLayerResult& result, const lie::SE3d& T_body0_body1) {
  const lie::SE3d& T = result.T_body0_body1;
  const Eigen::Vector3d& p = T_body0_body1.translation();
  return {(T.inverse() * T_body0_body1).log().tail<3>().norm(),
          (T.translation() - p).norm() / p.norm()};
}

/// Median errors over camera motions of this kind: rotation [rad], translation [share of length].
struct MedianErrors {
  double rotation = 0.0;
  double translation = 0.0;
};

template <typename DrawMotion>
MedianErrors median_errors(const DrawMotion& draw_motion) {
  const StereoCamera camera = testing::test_camera();
  Random random(1);
  std::vector<double> rotation;
  std::vector<double> translation;
  for (int trial = 0; trial < 21; ++trial) {
    const lie::SE3d T_left0_left1 = draw_motion(random);
    const lie::SE3d T = camera.T_body_left * T_left0_left1 * camera.T_body_left.inverse();
    const PoseLayerResult result = solve(room_points(camera, T, 0.1, random), camera);
    EXPECT_TRUE(result.valid);
    rotation.push_back(errors_of(result, T).rotation);
    translation.push_back(errors_of(result, T).translation);
  }
  std::sort(rotation.begin(), rotation.end());
  std::sort(translation.begin(), translation.end());
  return {rotation[10], translation[10]};
}

TEST(RegressionHead, FindsForwardMotionThroughARoom) {
  const MedianErrors errors = median_errors([](Random& random) {
    return lie::SE3d{lie::SO3d::exp(0.005 * random.normal3()),
                     Eigen::Vector3d{0.01 * random.normal(), 0.01 * random.normal(), 0.25}};
  });
  EXPECT_LT(errors.rotation, 0.006);
  EXPECT_LT(errors.translation, 0.2);
}

// Before a wall a turn and a sidestep look nearly alike: the network tells them apart only in part.
TEST(RegressionHead, ForAnyMotionItIsBetterThanNothing) {
  const MedianErrors errors = median_errors([](Random& random) {
    return lie::SE3d{lie::SO3d::exp(0.02 * random.normal3().normalized()),
                     0.1 * random.normal3().normalized()};
  });
  EXPECT_LT(errors.rotation, 0.7 * 0.02);
  EXPECT_LT(errors.translation, 0.7);
}

TEST(RegressionHead, StandsStillWhereNothingMoves) {
  const StereoCamera camera = testing::test_camera();
  PointNoise noise;
  noise.flow = 0.1;
  noise.disparity = 0.1;
  Random random(1);
  const auto points = testing::synthetic_correspondences(camera, lie::SE3d(), 400, noise, random);
  const PoseLayerResult result = solve(points, camera);
  EXPECT_TRUE(result.valid);
  EXPECT_LT(result.T_body0_body1.log().norm(), 2e-3);
}

TEST(RegressionHead, CovarianceIsSymmetricPositiveAndThatOfTheBody) {
  const StereoCamera camera = testing::test_camera();
  Random random(1);
  const auto points = room_points(camera, testing::test_motion(), 0.1, random);
  const PoseLayerResult result = solve(points, camera);
  ASSERT_TRUE(result.valid);
  const Eigen::Matrix<double, 6, 6>& C = result.covariance;
  testing::expect_near(C, C.transpose(), 1e-12);
  EXPECT_GT(
      (Eigen::SelfAdjointEigenSolver<Eigen::Matrix<double, 6, 6>>(C).eigenvalues().minCoeff()),
      0.0);
  StereoCamera at_body = camera;
  at_body.T_body_left = lie::SE3d();
  const PoseLayerResult left = solve(points, at_body);
  const auto adjoint = camera.T_body_left.adjoint();
  testing::expect_near(1e6 * C, 1e6 * adjoint * left.covariance * adjoint.transpose(), 1e-9);
}

TEST(RegressionHead, JacobianOfTheDisparityOffsetMatchesCentralDifferences) {
  const StereoCamera camera = testing::test_camera();
  Random random(1);
  const auto points = room_points(camera, testing::test_motion(), 0.1, random);
  RegressionOptions options;
  options.scale.adapt_noise_scale = false;
  const RegressionHead head(options, load_pose_head("").network);
  const PoseLayerResult result = head.solve(points, camera, {});
  ASSERT_TRUE(result.valid);
  const auto moved = [&](const Eigen::VectorXd& x) -> Eigen::VectorXd {
    const PoseLayerResult other = head.solve(points, camera, {}, x[0]);
    return (result.T_body0_body1.inverse() * other.T_body0_body1).log();
  };
  testing::expect_near(result.J_disparity_offset,
                       testing::numeric_jacobian(moved, Eigen::VectorXd::Zero(1), 1e-4), 1e-6);
}

TEST(RegressionHead, NothingUsableIsNotValidAndNotFinitePointsDoNoHarm) {
  const StereoCamera camera = testing::test_camera();
  EXPECT_FALSE(solve({}, camera).valid);
  Random random(1);
  auto points = room_points(camera, testing::test_motion(), 0.1, random);
  const PoseLayerResult before = solve(points, camera);
  Correspondence broken = points[0];
  broken.left1.x() = std::nan("");
  points.push_back(broken);
  broken = points[1];
  broken.left1.x() = 1e300;
  broken.weight = 0.0;
  points.push_back(broken);
  const PoseLayerResult after = solve(points, camera);
  EXPECT_TRUE(after.valid);
  EXPECT_LT((before.T_body0_body1.inverse() * after.T_body0_body1).log().norm(), 1e-9);
}

TEST(PoseHeadWeights, AFileOfAnotherNetworkIsRefused) {
  const testing::TempDir dir;
  Random random(1);
  PoseHead<float> other({4, 4, 4, 4, 1}, random);
  nn::ParameterList<float> parameters;
  other.collect(parameters);
  nn::save_parameters(dir.path() / "other", parameters, {});
  EXPECT_THROW(load_pose_head((dir.path() / "other").string()), InputError);
  VoOptions options;
  options.head = "regression";
  options.regression.weights = (dir.path() / "missing").string();
  EXPECT_THROW(VisualOdometry(options, testing::test_camera()), InputError);
}

}  // namespace
}  // namespace imslam::vo
