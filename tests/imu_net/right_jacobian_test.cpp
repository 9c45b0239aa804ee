#include "imu_net/right_jacobian.hpp"

#include <gtest/gtest.h>

#include "slam/lie/so3.hpp"
#include "tests/support/numeric_jacobian.hpp"

namespace imslam::imu {
namespace {

using imslam::testing::expect_near;
using imslam::testing::numeric_jacobian;

TEST(Axial, IsTheAdjointOfSkew) {
  Eigen::Matrix3d X;
  X << 1, 2, 3, -4, 5, 7, 0.5, -0.3, 2;
  const Eigen::Vector3d d(0.3, -1.1, 0.7);
  EXPECT_NEAR(axial(X).dot(d), X.cwiseProduct(lie::skew(d)).sum(), 1e-14);
}

TEST(RightJacobianGradient, MatchesCentralDifferencesFromTinyToLargeAngles) {
  Eigen::Matrix3d D;
  D << 1, 2, 3, -4, 5, 7, 0.5, -0.3, 2;
  const Eigen::Vector3d axis = Eigen::Vector3d(0.5, -0.7, 0.2).normalized();
  for (const double angle : {0.0, 1e-9, 1e-4, 0.1, 0.3161, 0.3163, 1.0, 3.0}) {
    const auto loss = [&](const Eigen::VectorXd& w) -> Eigen::VectorXd {
      const double value = D.cwiseProduct(right_jacobian(w)).sum();
      return Eigen::VectorXd::Constant(1, value);
    };
    const Eigen::VectorXd w = angle * axis;
    const Eigen::MatrixXd expected = numeric_jacobian(loss, w, 1e-4).transpose();
    expect_near(right_jacobian_gradient(w, D), expected, 1e-7);
  }
}

TEST(RightJacobian, MatchesThatOfTheLieRoom) {
  const Eigen::Vector3d axis = Eigen::Vector3d(0.5, -0.7, 0.2).normalized();
  for (const double angle : {0.0, 1e-9, 1e-4, 0.1, 0.3161, 0.3163, 1.0, 3.0}) {
    expect_near(right_jacobian(angle * axis), lie::SO3d::right_jacobian(angle * axis), 1e-15);
  }
}

TEST(RightJacobianGradient, SeriesAndClosedFormMeet) {
  Eigen::Matrix3d D;
  D << 1, 2, 3, -4, 5, 7, 0.5, -0.3, 2;
  const Eigen::Vector3d axis = Eigen::Vector3d(0.5, -0.7, 0.2).normalized();
  const double angle = std::sqrt(0.1);
  expect_near(right_jacobian_gradient((angle - 1e-13) * axis, D),
              right_jacobian_gradient((angle + 1e-13) * axis, D), 2e-12);
}

}  // namespace
}  // namespace imslam::imu
