#include "vo_net/pose_layer_gradient.hpp"

#include <gtest/gtest.h>

#include "slam/base/error.hpp"
#include "tests/support/numeric_jacobian.hpp"
#include "tests/vo_net/synthetic_points.hpp"
#include "vo_net/pose_layer_system.hpp"

namespace imslam::vo {
namespace {

using testing::synthetic_correspondences;
using testing::test_camera;
using testing::test_motion;
using Vector6 = Eigen::Matrix<double, 6, 1>;

constexpr int kNumbers = 12;

/// Everything a correspondence holds, the flow information as its three free entries.
Eigen::VectorXd pack(const Correspondence& c) {
  Eigen::VectorXd x(kNumbers);
  x << c.left0, c.left1, c.disparity0, c.disparity1, c.flow_information(0, 0),
      c.flow_information(0, 1), c.flow_information(1, 1), c.disparity0_information,
      c.disparity1_information, c.weight;
  return x;
}

Correspondence unpack(const Eigen::VectorXd& x) {
  Correspondence c;
  c.left0 = x.segment<2>(0);
  c.left1 = x.segment<2>(2);
  c.disparity0 = x[4];
  c.disparity1 = x[5];
  c.flow_information << x[6], x[7], x[7], x[8];
  c.disparity0_information = x[9];
  c.disparity1_information = x[10];
  c.weight = x[11];
  return c;
}

Eigen::VectorXd pack(const CorrespondenceGradient& g) {
  Eigen::VectorXd x(kNumbers);
  x << g.left0, g.left1, g.disparity0, g.disparity1, g.flow_information(0, 0),
      2.0 * g.flow_information(0, 1), g.flow_information(1, 1), g.disparity0_information,
      g.disparity1_information, g.weight;
  return x;
}

Correspondences uneven_correspondences(Random& random, const StereoCamera& camera) {
  Correspondences all =
      synthetic_correspondences(camera, test_motion(), 30, {0.4, 0.3, 0.0}, random);
  for (Correspondence& c : all) {
    c.flow_information << random.uniform(2.0, 6.0), random.uniform(-1.0, 1.0), 0.0,
        random.uniform(2.0, 6.0);
    c.flow_information(1, 0) = c.flow_information(0, 1);
    c.disparity0_information = random.uniform(3.0, 9.0);
    c.disparity1_information = random.uniform(3.0, 9.0);
    c.weight = random.uniform(0.3, 1.0);
  }
  return all;
}

PoseLayerOptions exact_options(const std::string& kernel) {
  PoseLayerOptions options;
  options.kernel = kernel;
  options.adapt_noise_scale = false;
  options.tolerance = 1e-11;
  return options;
}

class PoseLayerGradientKernels : public ::testing::TestWithParam<std::string> {};

TEST_P(PoseLayerGradientKernels, MatchesCentralDifferencesThroughTheWholeSolve) {
  Random random(21);
  const StereoCamera camera = test_camera();
  const Correspondences c = uneven_correspondences(random, camera);
  const PoseLayerOptions options = exact_options(GetParam());
  const PoseLayerResult middle = solve_pose(c, camera, options);
  ASSERT_TRUE(middle.valid);
  const Vector6 dL_dpose = (Vector6() << 0.3, -1.0, 0.7, 2.0, -0.4, 1.1).finished();
  const auto gradient = pose_layer_gradient(c, camera, options, middle, dL_dpose);
  ASSERT_TRUE(gradient.has_value());

  for (std::size_t k = 0; k < c.size(); k += 4) {
    const auto loss = [&](const Eigen::VectorXd& x) {
      Correspondences changed = c;
      changed[k] = unpack(x);
      const PoseLayerResult r = solve_pose(changed, camera, options);
      const Vector6 tau = (middle.T_body0_body1.inverse() * r.T_body0_body1).log();
      return Eigen::VectorXd::Constant(1, dL_dpose.dot(tau));
    };
    const Eigen::VectorXd numeric = testing::numeric_jacobian(loss, pack(c[k]), 2e-4).transpose();
    const Eigen::VectorXd analytic = pack(gradient->correspondences[k]);
    EXPECT_LT((analytic - numeric).norm(), 1e-6 * numeric.norm())
        << k << "\nanalytic " << analytic.transpose() << "\nnumeric  " << numeric.transpose();
  }
}

INSTANTIATE_TEST_SUITE_P(All,
                         PoseLayerGradientKernels,
                         ::testing::Values("none", "huber", "cauchy", "geman_mcclure"));

TEST(PoseLayerGradient, OffsetDerivativeIsTheProductWithItsJacobian) {
  Random random(22);
  const StereoCamera camera = test_camera();
  const Correspondences c = uneven_correspondences(random, camera);
  const PoseLayerOptions options = exact_options("cauchy");
  const PoseLayerResult result = solve_pose(c, camera, options);
  const Vector6 dL_dpose = Vector6::LinSpaced(6, -1.0, 1.0);
  const auto gradient = pose_layer_gradient(c, camera, options, result, dL_dpose);
  ASSERT_TRUE(gradient.has_value());
  // An offset shifts both disparities of every point down.
  double sum = 0.0;
  for (const auto& g : gradient->correspondences) sum -= g.disparity0 + g.disparity1;
  EXPECT_NEAR(gradient->disparity_offset, sum, 1e-9 * std::abs(sum));
}

TEST(PoseLayerGradient, RefusesWhatIsNotAMinimum) {
  Random random(23);
  const StereoCamera camera = test_camera();
  const Correspondences c = uneven_correspondences(random, camera);
  const PoseLayerOptions options = exact_options("cauchy");
  PoseLayerResult result = solve_pose(c, camera, options);
  result.T_body0_body1 = result.T_body0_body1 * lie::SE3d::exp(Vector6::Constant(1e-4));
  EXPECT_FALSE(pose_layer_gradient(c, camera, options, result, Vector6::Ones()).has_value());
  result.valid = false;
  EXPECT_FALSE(pose_layer_gradient(c, camera, options, result, Vector6::Ones()).has_value());
  result.disparities.pop_back();
  EXPECT_THROW(pose_layer_gradient(c, camera, options, result, Vector6::Ones()), ContractError);
}

TEST(PoseLayerPoint, JacobianAndCurvatureMatchCentralDifferences) {
  const StereoCamera camera = test_camera();
  const lie::SE3d T = test_motion();
  Correspondence c;
  c.left0 = {500.0, 90.0};
  c.left1 = {480.0, 110.0};
  c.disparity0 = 20.0;
  c.disparity1 = 21.0;
  const Eigen::Vector4d f(0.7, -1.3, 0.4, 2.1);
  const auto residual = [&](const Eigen::VectorXd& x) -> Eigen::VectorXd {
    StereoCamera other = camera;  // the law of depth, fx baseline, stays
    other.fx *= 1.0 + x[8];
    other.fy *= 1.0 + x[8];
    other.baseline_m /= 1.0 + x[8];
    const detail::Views views(other, T * lie::SE3d::exp(x.head<6>()), 0.3 + x[7]);
    return detail::evaluate_point(views, c, 19.0 + x[6]).e;
  };
  const detail::Views views(camera, T, 0.3);
  const detail::PointState point = detail::evaluate_point(views, c, 19.0);
  const Eigen::VectorXd zero = Eigen::VectorXd::Zero(detail::kUnknowns);
  testing::expect_near(detail::point_jacobian(views, point),
                       testing::numeric_jacobian(residual, zero, 1e-5), 1e-7);
  Eigen::MatrixXd second(detail::kUnknowns, detail::kUnknowns);
  const double h = 1e-3;
  for (int i = 0; i < detail::kUnknowns; ++i) {
    for (int j = 0; j < detail::kUnknowns; ++j) {
      const Eigen::VectorXd a = h * Eigen::VectorXd::Unit(detail::kUnknowns, i);
      const Eigen::VectorXd b = h * Eigen::VectorXd::Unit(detail::kUnknowns, j);
      second(i, j) = f.dot(residual(a + b) - residual(a - b) - residual(b - a) + residual(-a - b)) /
                     (4.0 * h * h);
    }
  }
  testing::expect_near(detail::curvature(views, point, f), second, 1e-5);
}

TEST(RobustKernel, DerivativesMatchCentralDifferences) {
  for (RobustKernel kernel : {RobustKernel::kNone, RobustKernel::kHuber, RobustKernel::kCauchy,
                              RobustKernel::kGemanMcClure}) {
    for (double s : {0.01, 0.9, 3.9, 4.1, 50.0}) {
      const double h = 1e-5;
      const KernelValue middle = evaluate_kernel(kernel, s, 4.0);
      const KernelValue more = evaluate_kernel(kernel, s + h, 4.0);
      const KernelValue less = evaluate_kernel(kernel, s - h, 4.0);
      EXPECT_NEAR(middle.first, (more.rho - less.rho) / (2.0 * h), 1e-8);
      EXPECT_NEAR(middle.second, (more.first - less.first) / (2.0 * h), 1e-8);
    }
  }
}

}  // namespace
}  // namespace imslam::vo
