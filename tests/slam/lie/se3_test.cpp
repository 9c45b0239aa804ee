#include "slam/lie/se3.hpp"

#include <gtest/gtest.h>

#include "tests/support/numeric_jacobian.hpp"

namespace imslam::lie {
namespace {

using testing::expect_near;
using testing::numeric_jacobian;
using Vector6d = Eigen::Matrix<double, 6, 1>;
using Matrix6d = Eigen::Matrix<double, 6, 6>;

Vector6d tangent(double x, double y, double z, double a, double b, double c) {
  return (Vector6d() << x, y, z, a, b, c).finished();
}

// Identity, tiny, around the switch of the series (angle 0.1), ordinary, close to a half turn.
const Vector6d kTangents[] = {
    Vector6d::Zero(),
    tangent(1e-3, -2e-3, 1e-3, 1e-6, 2e-6, -1e-6),
    tangent(1.0, 2.0, -1.0, 0.0999, 0.0, 0.0),
    tangent(1.0, 2.0, -1.0, 0.1001, 0.0, 0.0),
    tangent(0.3, -1.2, 0.7, 0.4, -0.2, 0.9),
    tangent(5.0, 0.1, -3.0, 3.1, 0.02, -0.03),
};

TEST(SE3, LogInvertsExp) {
  for (const Vector6d& tau : kTangents) expect_near(SE3d::exp(tau).log(), tau, 1e-9);
}

TEST(SE3, ExpMatchesTheMatrixSeries) {
  for (const Vector6d& tau : kTangents) {
    Eigen::Matrix4d hat = Eigen::Matrix4d::Zero();
    hat.topLeftCorner<3, 3>() = skew(tau.tail<3>());
    hat.topRightCorner<3, 1>() = tau.head<3>();
    Eigen::Matrix4d term = Eigen::Matrix4d::Identity();
    Eigen::Matrix4d sum = term;
    for (int k = 1; k < 40; ++k) sum += term = term * hat / k;
    expect_near(SE3d::exp(tau).matrix(), sum, 1e-12);
  }
}

TEST(SE3, GroupLawsHold) {
  const Eigen::Vector3d p(1.0, -2.0, 3.0);
  for (const Vector6d& a : kTangents) {
    const SE3d A = SE3d::exp(a);
    expect_near((A * A.inverse()).matrix(), Eigen::Matrix4d::Identity(), 1e-13);
    expect_near(SE3d::from_matrix(A.matrix()).matrix(), A.matrix(), 1e-13);
    for (const Vector6d& b : kTangents) {
      const SE3d B = SE3d::exp(b);
      expect_near((A * B).matrix(), A.matrix() * B.matrix(), 1e-13);
      expect_near((A * B) * p, A * (B * p), 1e-13);
    }
  }
}

TEST(SE3, ActJacobianMatchesCentralDifferences) {
  const Eigen::Vector3d p(1.0, -2.0, 3.0);
  for (const Vector6d& tau : kTangents) {
    const SE3d X = SE3d::exp(tau);
    SE3d::PointJacobian J_y_X;
    X.act(p, &J_y_X);
    const auto perturbed = [&](const Eigen::VectorXd& step) -> Eigen::VectorXd {
      return (X * SE3d::exp(step)).act(p);
    };
    expect_near(J_y_X, numeric_jacobian(perturbed, Vector6d::Zero()), 1e-7);
  }
}

TEST(SE3, AdjointMovesAStepFromRightToLeft) {
  const Vector6d step = tangent(0.1, 0.2, -0.1, 0.3, -0.4, 0.2);
  for (const Vector6d& tau : kTangents) {
    const SE3d X = SE3d::exp(tau);
    const SE3d left = SE3d::exp(X.adjoint() * step) * X;
    expect_near((left.inverse() * X * SE3d::exp(step)).log(), Vector6d::Zero(), 1e-9);
  }
}

TEST(SE3, LeftJacobianMatchesCentralDifferences) {
  for (const Vector6d& tau : kTangents) {
    const auto moved = [&](const Eigen::VectorXd& d) -> Eigen::VectorXd {
      return (SE3d::exp(tau + d) * SE3d::exp(tau).inverse()).log();
    };
    expect_near(SE3d::left_jacobian(tau), numeric_jacobian(moved, Vector6d::Zero(), 1e-5), 1e-7);
  }
}

TEST(SE3, RightJacobianMatchesCentralDifferences) {
  for (const Vector6d& tau : kTangents) {
    const auto moved = [&](const Eigen::VectorXd& d) -> Eigen::VectorXd {
      return (SE3d::exp(tau).inverse() * SE3d::exp(tau + d)).log();
    };
    expect_near(SE3d::right_jacobian(tau), numeric_jacobian(moved, Vector6d::Zero(), 1e-5), 1e-7);
  }
}

TEST(SE3, InverseJacobiansInvert) {
  for (const Vector6d& tau : kTangents) {
    expect_near(SE3d::left_jacobian(tau) * SE3d::left_jacobian_inverse(tau), Matrix6d::Identity(),
                1e-10);
    expect_near(SE3d::right_jacobian(tau) * SE3d::right_jacobian_inverse(tau), Matrix6d::Identity(),
                1e-10);
  }
}

TEST(SE3, CastKeepsThePose) {
  const SE3d X = SE3d::exp(kTangents[4]);
  expect_near(X.cast<float>().cast<double>().matrix(), X.matrix(), 1e-6);
}

}  // namespace
}  // namespace imslam::lie
