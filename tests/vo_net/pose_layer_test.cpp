#include "vo_net/pose_layer.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "slam/base/error.hpp"
#include "tests/vo_net/synthetic_points.hpp"

namespace imslam::vo {
namespace {

using testing::PointNoise;
using testing::synthetic_correspondences;
using testing::test_camera;
using testing::test_motion;
using Vector6 = Eigen::Matrix<double, 6, 1>;

Vector6 error_of(const PoseLayerResult& result, const lie::SE3d& truth) {
  return (result.T_body0_body1.inverse() * truth).log();
}

bool all_finite(const PoseLayerResult& r) {
  return r.T_body0_body1.matrix().allFinite() && r.covariance.allFinite() &&
         r.J_disparity_offset.allFinite() && std::isfinite(r.cost) &&
         std::isfinite(r.offset_gradient) && std::isfinite(r.offset_information);
}

class PoseLayerKernels : public ::testing::TestWithParam<std::string> {};

TEST_P(PoseLayerKernels, RecoversNoiseFreeMotionToRounding) {
  Random random(1);
  const StereoCamera camera = test_camera();
  PoseLayerOptions options;
  options.kernel = GetParam();
  for (int trial = 0; trial < 5; ++trial) {
    const Correspondences c =
        synthetic_correspondences(camera, test_motion(), 60, PointNoise(), random);
    const PoseLayerResult result = solve_pose(c, camera, options);
    ASSERT_TRUE(result.valid);
    EXPECT_LT(error_of(result, test_motion()).norm(), 1e-9);
    EXPECT_EQ(result.inliers, 60);
  }
}

TEST_P(PoseLayerKernels, CovarianceIsThatOfTheError) {
  Random random(2);
  const StereoCamera camera = test_camera();
  PoseLayerOptions options;
  options.kernel = GetParam();
  const int runs = 400;
  double nees = 0.0;
  for (int run = 0; run < runs; ++run) {
    const Correspondences c =
        synthetic_correspondences(camera, test_motion(), 150, {0.15, 0.2, 0.0}, random);
    const PoseLayerResult result = solve_pose(c, camera, options, test_motion());
    ASSERT_TRUE(result.valid);
    const Vector6 e = error_of(result, test_motion());
    nees += e.dot(result.covariance.ldlt().solve(e)) / runs;
  }
  // chi-square with 6 x 400 degrees of freedom, 99.9 %: 6 +- 0.57; a little for the scale's own
  // noise
  EXPECT_NEAR(nees, 6.0, 0.75);
}

TEST_P(PoseLayerKernels, CovarianceDoesNotDependOnTheUnitOfTheInformations) {
  Random random(3);
  const StereoCamera camera = test_camera();
  PoseLayerOptions options;
  options.kernel = GetParam();
  Correspondences c =
      synthetic_correspondences(camera, test_motion(), 200, {0.1, 0.1, 0.0}, random);
  const PoseLayerResult right = solve_pose(c, camera, options);
  for (Correspondence& one : c) {
    one.flow_information /= 9.0;
    one.disparity0_information /= 9.0;
    one.disparity1_information /= 9.0;
  }
  const PoseLayerResult scaled = solve_pose(c, camera, options);
  EXPECT_NEAR(scaled.noise_scale * 3.0, right.noise_scale, 0.01);
  EXPECT_LT((scaled.covariance - right.covariance).norm(), 0.02 * right.covariance.norm());
}

INSTANTIATE_TEST_SUITE_P(All,
                         PoseLayerKernels,
                         ::testing::Values("none", "huber", "cauchy", "geman_mcclure"));

TEST(PoseLayer, IsNotShortInScaleWhenDepthsAreNoisy) {
  Random random(4);
  const StereoCamera camera = test_camera();
  const lie::SE3d forward = camera.T_body_left *
                            lie::SE3d(lie::SO3d(), Eigen::Vector3d(0.0, 0.0, 0.2)) *
                            camera.T_body_left.inverse();
  double length = 0.0;
  const int runs = 60;
  for (int run = 0; run < runs; ++run) {
    const Correspondences c =
        synthetic_correspondences(camera, forward, 400, {0.1, 0.4, 0.0}, random);
    length += solve_pose(c, camera, {}).T_body0_body1.translation().norm() / runs;
  }
  EXPECT_NEAR(length / 0.2, 1.0, 0.003);
}

TEST(PoseLayer, BearsFortyPercentGrossOutliers) {
  Random random(5);
  const StereoCamera camera = test_camera();
  for (int trial = 0; trial < 20; ++trial) {
    Correspondences c =
        synthetic_correspondences(camera, test_motion(), 300, {0.1, 0.1, 0.0}, random);
    for (std::size_t k = 0; k < 120; ++k) {
      c[k].left1 = {random.uniform(0.0, 752.0), random.uniform(0.0, 480.0)};
      c[k].disparity1 = random.uniform(0.0, 60.0);
    }
    const PoseLayerResult result = solve_pose(c, camera, {});
    ASSERT_TRUE(result.valid) << trial;
    EXPECT_LT(error_of(result, test_motion()).head<3>().norm(), 0.004);
    EXPECT_LT(error_of(result, test_motion()).tail<3>().norm(), 0.001);
    EXPECT_EQ(std::count(result.is_inlier.begin(), result.is_inlier.begin() + 120, 1), 0);
  }
}

TEST(PoseLayer, BearsAnObjectThatMovesOnItsOwn) {
  Random random(6);
  const StereoCamera camera = test_camera();
  Correspondences c =
      synthetic_correspondences(camera, test_motion(), 300, {0.1, 0.1, 0.0}, random);
  const lie::SE3d other = lie::SE3d::exp((Vector6() << 0.3, 0.1, -0.1, 0.01, 0.0, 0.02).finished());
  const Correspondences moving =
      synthetic_correspondences(camera, other, 90, {0.1, 0.1, 0.0}, random);
  c.insert(c.end(), moving.begin(), moving.end());
  const PoseLayerResult result = solve_pose(c, camera, {});
  ASSERT_TRUE(result.valid);
  EXPECT_LT(error_of(result, test_motion()).norm(), 0.002);
}

TEST(PoseLayer, PointsThatDoNotAgreeGiveNoMotion) {
  Random random(15);
  const StereoCamera camera = test_camera();
  for (int trial = 0; trial < 20; ++trial) {
    Correspondences c =
        synthetic_correspondences(camera, test_motion(), 80, {0.1, 0.1, 0.0}, random);
    for (Correspondence& one : c) {
      one.left1 = {random.uniform(0.0, 752.0), random.uniform(0.0, 480.0)};
      one.disparity1 = random.uniform(0.0, 60.0);
    }
    EXPECT_FALSE(solve_pose(c, camera, {}).valid);
  }
}

TEST(PoseLayer, IgnoresWhatIsNotFinite) {
  Random random(7);
  const StereoCamera camera = test_camera();
  Correspondences c = synthetic_correspondences(camera, test_motion(), 60, PointNoise(), random);
  const double nan = std::numeric_limits<double>::quiet_NaN();
  c[0].left1.x() = nan;
  c[1].disparity0 = std::numeric_limits<double>::infinity();
  c[2].flow_information(0, 1) = nan;
  c[3].weight = 0.0;
  c[4].disparity0_information = -1.0;
  const PoseLayerResult result = solve_pose(c, camera, {});
  ASSERT_TRUE(result.valid);
  EXPECT_EQ(result.inliers, 55);
  EXPECT_LT(error_of(result, test_motion()).norm(), 1e-9);
}

TEST(PoseLayer, WorksWithoutTheSecondDisparity) {
  Random random(8);
  const StereoCamera camera = test_camera();
  Correspondences c = synthetic_correspondences(camera, test_motion(), 60, PointNoise(), random);
  for (Correspondence& one : c) one.disparity1_information = 0.0;
  const PoseLayerResult result = solve_pose(c, camera, {});
  ASSERT_TRUE(result.valid);
  EXPECT_LT(error_of(result, test_motion()).norm(), 1e-9);
}

TEST(PoseLayer, PointsAtInfinityGiveTheRotationButNoValidMotion) {
  const StereoCamera camera = test_camera();
  Random random(9);
  Correspondences c = synthetic_correspondences(camera, lie::SE3d(), 60, PointNoise(), random);
  for (Correspondence& one : c) one.disparity0 = one.disparity1 = 0.0;
  const PoseLayerResult result = solve_pose(c, camera, {});
  EXPECT_FALSE(result.valid);
  EXPECT_TRUE(all_finite(result));
}

TEST(PoseLayer, RejectsPointsOnALine) {
  const StereoCamera camera = test_camera();
  const lie::SE3d T_left1_left0 =
      camera.T_body_left.inverse() * test_motion().inverse() * camera.T_body_left;
  Correspondences c;
  for (int k = 0; k < 40; ++k) {
    const Eigen::Vector3d p(0.05 * k - 1.0, 0.03 * k, 4.0 + 0.02 * k);
    const Eigen::Vector3d before = camera.project(p);
    const Eigen::Vector3d after = camera.project(T_left1_left0 * p);
    Correspondence one;
    one.left0 = before.head<2>();
    one.left1 = after.head<2>();
    one.disparity0 = before.z();
    one.disparity1 = after.z();
    c.push_back(one);
  }
  const PoseLayerResult result = solve_pose(c, camera, {});
  EXPECT_FALSE(result.valid);
  EXPECT_TRUE(all_finite(result));
}

TEST(PoseLayer, TooFewPointsOrNoneAreNotValid) {
  Random random(10);
  const StereoCamera camera = test_camera();
  for (int count : {0, 1, 2, 3, 5, 9}) {
    const PoseLayerResult result = solve_pose(
        synthetic_correspondences(camera, test_motion(), count, PointNoise(), random), camera, {});
    EXPECT_FALSE(result.valid) << count;
    EXPECT_TRUE(all_finite(result)) << count;
  }
}

TEST(PoseLayer, NeverReturnsNonFiniteNumbersOnRandomInput) {
  Random random(11);
  const StereoCamera camera = test_camera();
  for (int trial = 0; trial < 200; ++trial) {
    Correspondences c(static_cast<std::size_t>(random.integer(0, 40)));
    const double spread = std::pow(10.0, random.uniform(-3.0, 6.0));
    for (Correspondence& one : c) {
      one.left0 = spread * Eigen::Vector2d{random.normal(), random.normal()};
      one.left1 = spread * Eigen::Vector2d{random.normal(), random.normal()};
      one.disparity0 = spread * random.normal();
      one.disparity1 = spread * random.normal();
      one.weight = random.uniform();
    }
    const lie::SE3d start =
        lie::SE3d::exp((Vector6() << random.normal3(), random.normal3()).finished());
    EXPECT_TRUE(all_finite(solve_pose(c, camera, {}, start))) << trial;
  }
}

TEST(PoseLayer, MirroredSceneGivesTheMirroredMotion) {
  Random random(12);
  StereoCamera camera = test_camera();
  camera.T_body_left = lie::SE3d();
  Correspondences c = synthetic_correspondences(camera, test_motion(), 80, {0.1, 0.1, 0.0}, random);
  const PoseLayerResult straight = solve_pose(c, camera, {});
  for (Correspondence& one : c) {  // upside down: y -> -y keeps left and right apart
    one.left0.y() = 2.0 * camera.cy - one.left0.y();
    one.left1.y() = 2.0 * camera.cy - one.left1.y();
  }
  const PoseLayerResult mirrored = solve_pose(c, camera, {});
  const Eigen::Vector3d flip(1.0, -1.0, 1.0);
  EXPECT_LT((mirrored.T_body0_body1.translation() -
             flip.cwiseProduct(straight.T_body0_body1.translation()))
                .norm(),
            1e-9);
  const Eigen::Vector3d turn(-1.0, 1.0, -1.0);
  EXPECT_LT((mirrored.T_body0_body1.rotation().log() -
             turn.cwiseProduct(straight.T_body0_body1.rotation().log()))
                .norm(),
            1e-9);
}

TEST(PoseLayer, DerivativeByTheOffsetMatchesCentralDifferences) {
  Random random(13);
  const StereoCamera camera = test_camera();
  PoseLayerOptions options;
  options.adapt_noise_scale = false;
  options.tolerance = 1e-10;
  const Correspondences c =
      synthetic_correspondences(camera, test_motion(), 60, {0.1, 0.1, 0.2}, random);
  const PoseLayerResult middle = solve_pose(c, camera, options, {}, 0.1);
  const double h = 1e-4;
  const PoseLayerResult more = solve_pose(c, camera, options, {}, 0.1 + h);
  const PoseLayerResult less = solve_pose(c, camera, options, {}, 0.1 - h);
  const Vector6 numeric = (less.T_body0_body1.inverse() * more.T_body0_body1).log() / (2.0 * h);
  EXPECT_LT((numeric - middle.J_disparity_offset).norm(), 1e-6 * numeric.norm());
}

TEST(PoseLayer, DerivativeByTheFocalLengthMatchesCentralDifferences) {
  Random random(15);
  const StereoCamera camera = test_camera();
  PoseLayerOptions options;
  options.adapt_noise_scale = false;
  options.tolerance = 1e-10;
  const Correspondences c =
      synthetic_correspondences(camera, test_motion(), 60, {0.1, 0.1, 0.2}, random);
  const PoseLayerResult middle = solve_pose(c, camera, options, {}, 0.1);
  const double h = 1e-5;
  const auto solved_with = [&](double focal_error) {
    StereoCamera other = camera;  // the law of depth, fx baseline, stays
    other.fx *= 1.0 + focal_error;
    other.fy *= 1.0 + focal_error;
    other.baseline_m /= 1.0 + focal_error;
    return solve_pose(c, other, options, {}, 0.1).T_body0_body1;
  };
  const Vector6 numeric = (solved_with(-h).inverse() * solved_with(h)).log() / (2.0 * h);
  EXPECT_LT((numeric - middle.J_focal_error).norm(), 1e-6 * numeric.norm());
}

TEST(PoseLayer, OffsetGradientLeadsToTheTrueOffset) {
  double offset = 0.0;
  double sigma = 0.0;
  for (int round = 0; round < 3;
       ++round) {  // Newton: the likelihood is not quadratic in the offset
    Random random(14);
    const StereoCamera camera = test_camera();
    double gradient = 0.0;
    double information = 0.0;
    for (int frame = 0; frame < 100; ++frame) {
      const Correspondences c =
          synthetic_correspondences(camera, test_motion(), 200, {0.1, 0.1, 0.3}, random);
      const PoseLayerResult result = solve_pose(c, camera, {}, {}, offset);
      gradient += result.offset_gradient;
      information += result.offset_information;
    }
    offset -= gradient / information;
    sigma = 1.0 / std::sqrt(information);
  }
  EXPECT_NEAR(offset, 0.3, 4.0 * sigma);
  EXPECT_LT(sigma, 0.05);
}

TEST(PoseLayerOptions, NamesTheKeyThatIsOutOfBounds) {
  PoseLayerOptions options;
  options.kernel_width = -1.0;
  try {
    options.validate();
    FAIL() << "accepted a negative width";
  } catch (const InputError& error) {
    EXPECT_EQ(error.code(), ExitCode::kUsage);
    EXPECT_NE(std::string(error.what()).find("vo.pose.kernel_width"), std::string::npos);
  }
}

}  // namespace
}  // namespace imslam::vo
