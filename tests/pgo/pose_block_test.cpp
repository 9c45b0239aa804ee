#include "pgo/pose_block.hpp"

#include <ceres/manifold_test_utils.h>
#include <gtest/gtest.h>

#include "slam/base/random.hpp"
#include "tests/pgo/synthetic.hpp"
#include "tests/support/numeric_jacobian.hpp"

namespace imslam::pgo {
namespace {

using testing::expect_near;
using testing::numeric_jacobian;
using testing::Vector6;
using Vector7 = Eigen::Matrix<double, 7, 1>;

std::vector<lie::SE3d> poses() {
  Random random(3);
  std::vector<lie::SE3d> result = {lie::SE3d()};
  for (double angle : {1e-9, 1e-3, 0.7, 3.1, M_PI}) {
    result.push_back({lie::SO3d::exp(angle * random.normal3().normalized()), random.normal3()});
  }
  return result;
}

TEST(PoseManifold, PlusJacobianMatchesCentralDifferences) {
  const PoseManifold manifold;
  for (const lie::SE3d& pose : poses()) {
    Vector7 x;
    pose_to_block(pose, x.data());
    const auto plus = [&](const Eigen::VectorXd& tau) -> Eigen::VectorXd {
      Vector7 y;
      manifold.Plus(x.data(), tau.data(), y.data());
      return y;
    };
    expect_near(pose_plus_jacobian(x.data()), numeric_jacobian(plus, Vector6::Zero()), 1e-9);
  }
}

TEST(PoseManifold, MinusJacobianMatchesCentralDifferences) {
  const PoseManifold manifold;
  for (const lie::SE3d& pose : poses()) {
    Vector7 x;
    pose_to_block(pose, x.data());
    // On the manifold only: move along the tangent and compare J_minus J_plus.
    const auto minus = [&](const Eigen::VectorXd& tau) -> Eigen::VectorXd {
      Vector7 y;
      Vector6 back;
      manifold.Plus(x.data(), tau.data(), y.data());
      manifold.Minus(y.data(), x.data(), back.data());
      return back;
    };
    const Eigen::MatrixXd product = pose_minus_jacobian(x.data()) * pose_plus_jacobian(x.data());
    expect_near(product, numeric_jacobian(minus, Vector6::Zero()), 1e-9);
    expect_near(product, Eigen::MatrixXd::Identity(6, 6), 1e-12);
  }
}

TEST(PoseManifold, MinusUndoesPlus) {
  const PoseManifold manifold;
  Random random(5);
  for (const lie::SE3d& pose : poses()) {
    for (double size : {0.0, 1e-9, 1e-3, 1.0}) {
      Vector7 x;
      Vector7 y;
      Vector6 back;
      pose_to_block(pose, x.data());
      const Vector6 tau = size * testing::random_matrix<6, 1>(random);
      manifold.Plus(x.data(), tau.data(), y.data());
      manifold.Minus(y.data(), x.data(), back.data());
      EXPECT_LT((back - tau).norm(), 1e-12 + 1e-12 * tau.norm());
    }
  }
}

TEST(PoseManifold, CeresFindsItsJacobiansConsistent) {
  const PoseManifold manifold;
  Random random(6);
  for (const lie::SE3d& pose : poses()) {
    Vector7 x;
    Vector7 y;
    pose_to_block(pose, x.data());
    const Vector6 tau = testing::random_matrix<6, 1>(random);
    manifold.Plus(x.data(), tau.data(), y.data());
    ASSERT_TRUE(y.allFinite());
    Eigen::Matrix<double, 7, 6, Eigen::RowMajor> J_plus;
    Eigen::Matrix<double, 6, 7, Eigen::RowMajor> J_minus;
    ASSERT_TRUE(manifold.PlusJacobian(x.data(), J_plus.data()));
    ASSERT_TRUE(manifold.MinusJacobian(x.data(), J_minus.data()));
    expect_near(J_minus * J_plus, Eigen::MatrixXd::Identity(6, 6), 1e-12);
  }
}

}  // namespace
}  // namespace imslam::pgo
