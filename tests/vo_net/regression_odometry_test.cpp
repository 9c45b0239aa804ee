#include "vo_net/regression_odometry.hpp"

#include <gtest/gtest.h>

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

PoseLayerResult solve(const Correspondences& points, const StereoCamera& camera) {
  static const TrainedPoseHead kShipped = load_pose_head("");
  return RegressionHead({}, kShipped.network).solve(points, camera, PoseLayerOptions());
}

struct Errors {
  double rotation = 0.0;     ///< [rad]
  double translation = 0.0;  ///< share of the length
  Eigen::Matrix<double, 6, 1> tangent;
};

Errors errors_of(const PoseLayerResult& result, const lie::SE3d& T_body0_body1) {
  Errors errors;
  errors.tangent = (result.T_body0_body1.inverse() * T_body0_body1).log();
  errors.rotation = errors.tangent.tail<3>().norm();
  errors.translation = (result.T_body0_body1.translation() - T_body0_body1.translation()).norm() /
                       T_body0_body1.translation().norm();
  return errors;
}

/// A body motion of this length and angle.
lie::SE3d random_motion(double length, double angle, Random& random) {
  lie::SE3d::Tangent tau;
  tau << length * random.normal3().normalized(), angle * random.normal3().normalized();
  return lie::SE3d::exp(tau);
}

TEST(RegressionHead, FindsTheMotionOfUnseenPointsAboutRight) {
  const StereoCamera camera = testing::test_camera();
  PointNoise noise;
  noise.flow = 0.1;
  noise.disparity = 0.1;
  Random random(1);
  std::vector<double> rotation;
  std::vector<double> translation;
  for (int trial = 0; trial < 21; ++trial) {
    const lie::SE3d T = random_motion(0.1, 0.02, random);
    const auto points = testing::synthetic_correspondences(camera, T, 500, noise, random);
    const PoseLayerResult result = solve(points, camera);
    ASSERT_TRUE(result.valid);
    rotation.push_back(errors_of(result, T).rotation);
    translation.push_back(errors_of(result, T).translation);
  }
  std::sort(rotation.begin(), rotation.end());
  std::sort(translation.begin(), translation.end());
  EXPECT_LT(rotation[10], 0.004);
  EXPECT_LT(translation[10], 0.3);
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
  const auto points =
      testing::synthetic_correspondences(camera, testing::test_motion(), 300, {}, random);
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
  PointNoise noise;
  noise.disparity = 0.1;
  noise.flow = 0.1;
  Random random(1);
  const auto points =
      testing::synthetic_correspondences(camera, testing::test_motion(), 300, noise, random);
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
  auto points = testing::synthetic_correspondences(camera, testing::test_motion(), 300, {}, random);
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
