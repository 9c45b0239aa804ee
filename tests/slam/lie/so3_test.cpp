#include "slam/lie/so3.hpp"

#include <gtest/gtest.h>

#include "tests/support/numeric_jacobian.hpp"

namespace imslam::lie {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;
using testing::expect_near;
using testing::numeric_jacobian;

// Identity, tiny, both sides of the Taylor switch, ordinary, and close to a half turn.
const Vector3d kTangents[] = {
    Vector3d::Zero(),        {1e-9, -2e-9, 3e-9}, {0.99e-4, 0.0, 0.0}, {1.01e-4, 0.0, 0.0},
    {1e-3, -2e-3, 1e-3},     {0.4, -0.2, 0.9},    {-1.5, 1.0, 0.3},    {M_PI - 1e-3, 0.0, 0.0},
    {0.0, M_PI - 1e-7, 0.0}, {1.8, -1.8, 1.8},    {0.3161, 0.0, 0.0},  {0.3163, 0.0, 0.0},
};

// Any matrix: the slope of a loss by a Jacobian.
const Matrix3d kWeights = (Matrix3d() << 1, 2, 3, -4, 5, 7, 0.5, -0.3, 2).finished();

TEST(SO3, LogInvertsExp) {
  for (const Vector3d& theta : kTangents) expect_near(SO3d::exp(theta).log(), theta, 1e-9);
}

TEST(SO3, LogOfAHalfTurnIsAHalfTurn) {
  const Vector3d theta = SO3d(Eigen::Quaterniond(0.0, 0.6, 0.0, 0.8)).log();
  EXPECT_NEAR(theta.norm(), M_PI, 1e-12);
  expect_near(theta.cross(Vector3d(0.6, 0.0, 0.8)), Vector3d::Zero(), 1e-12);
}

TEST(SO3, OppositeQuaternionsAreTheSameRotation) {
  for (const Vector3d& theta : kTangents) {
    const Eigen::Quaterniond q = SO3d::exp(theta).quaternion();
    const SO3d opposite(Eigen::Quaterniond(-q.coeffs()));
    expect_near(opposite.log(), theta, 1e-9);
  }
}

TEST(SO3, ExpMatchesTheMatrixSeries) {
  for (const Vector3d& theta : kTangents) {
    Matrix3d term = Matrix3d::Identity();
    Matrix3d sum = term;
    for (int k = 1; k < 40; ++k) sum += term = term * skew(theta) / k;
    expect_near(SO3d::exp(theta).matrix(), sum, 1e-12);
  }
}

TEST(SO3, GroupLawsHold) {
  const Vector3d p(1.0, -2.0, 3.0);
  for (const Vector3d& a : kTangents) {
    const SO3d A = SO3d::exp(a);
    expect_near((A * A.inverse()).log(), Vector3d::Zero(), 1e-14);
    for (const Vector3d& b : kTangents) {
      const SO3d B = SO3d::exp(b);
      expect_near((A * B) * p, A * (B * p), 1e-13);
      expect_near((A * B).matrix(), A.matrix() * B.matrix(), 1e-13);
    }
  }
}

TEST(SO3, StaysUnitLengthOverManyProducts) {
  SO3d R;
  const SO3d step = SO3d::exp({0.01, -0.02, 0.03});
  for (int i = 0; i < 100000; ++i) R = R * step;
  EXPECT_NEAR(R.quaternion().norm(), 1.0, 1e-15);
}

TEST(SO3, FromMatrixFindsTheNearestRotation) {
  for (const Vector3d& theta : kTangents) {
    const Matrix3d R = SO3d::exp(theta).matrix();
    expect_near(SO3d::from_matrix(R).matrix(), R, 1e-12);
  }
  // Neither scale nor a symmetric stretch R (I + S) matters: both leave the nearest rotation where
  // it was.
  Matrix3d S;
  S << 0.02, 0.01, -0.01, 0.01, -0.03, 0.005, -0.01, 0.005, 0.01;
  const Matrix3d R = SO3d::exp({0.4, -0.2, 0.9}).matrix();
  for (const double size : {1.0, 30.0, -30.0}) {
    const Matrix3d stretch = Matrix3d::Identity() + size * S;
    expect_near(SO3d::from_matrix(R * stretch).matrix(), R, 1e-12);
    expect_near(SO3d::from_matrix(1e-3 * R * stretch).matrix(), R, 1e-12);
  }
}

TEST(SO3, LeftJacobianMatchesCentralDifferences) {
  for (const Vector3d& theta : kTangents) {
    const auto moved = [&](const Eigen::VectorXd& d) -> Eigen::VectorXd {
      return (SO3d::exp(theta + d) * SO3d::exp(theta).inverse()).log();
    };
    expect_near(SO3d::left_jacobian(theta), numeric_jacobian(moved, Vector3d::Zero()), 1e-8);
  }
}

TEST(SO3, RightJacobianMatchesCentralDifferences) {
  for (const Vector3d& theta : kTangents) {
    const auto moved = [&](const Eigen::VectorXd& d) -> Eigen::VectorXd {
      return (SO3d::exp(theta).inverse() * SO3d::exp(theta + d)).log();
    };
    expect_near(SO3d::right_jacobian(theta), numeric_jacobian(moved, Vector3d::Zero()), 1e-8);
  }
}

TEST(SO3, InverseJacobiansInvert) {
  for (const Vector3d& theta : kTangents) {
    expect_near(SO3d::left_jacobian(theta) * SO3d::left_jacobian_inverse(theta),
                Matrix3d::Identity(), 1e-9);
    expect_near(SO3d::right_jacobian(theta) * SO3d::right_jacobian_inverse(theta),
                Matrix3d::Identity(), 1e-9);
  }
}

TEST(SO3, NothingJumpsWhereTheSeriesTakesOver) {
  const Vector3d axis = Vector3d(1.0, -2.0, 0.5).normalized();
  const Vector3d small = std::sqrt(kSmallAngleSquared) * axis;
  const Vector3d below = (1.0 - 1e-9) * small;
  const Vector3d above = (1.0 + 1e-9) * small;
  expect_near(SO3d::exp(below).quaternion().coeffs(), SO3d::exp(above).quaternion().coeffs(),
              1e-12);
  expect_near(SO3d::left_jacobian_inverse(below), SO3d::left_jacobian_inverse(above), 1e-8);
  const Vector3d larger = std::sqrt(kSeriesAngleSquared) * axis;
  expect_near(SO3d::left_jacobian((1.0 - 1e-13) * larger),
              SO3d::left_jacobian((1.0 + 1e-13) * larger), 1e-13);
  expect_near(SO3d::right_jacobian_gradient((1.0 - 1e-13) * larger, kWeights),
              SO3d::right_jacobian_gradient((1.0 + 1e-13) * larger, kWeights), 2e-12);
}

TEST(SO3, RightJacobianGradientMatchesCentralDifferences) {
  for (const Vector3d& theta : kTangents) {
    const auto loss = [&](const Eigen::VectorXd& at) -> Eigen::VectorXd {
      const double value = kWeights.cwiseProduct(SO3d::right_jacobian(at)).sum();
      return Eigen::VectorXd::Constant(1, value);
    };
    const Eigen::MatrixXd expected = numeric_jacobian(loss, theta, 1e-4).transpose();
    expect_near(SO3d::right_jacobian_gradient(theta, kWeights), expected, 2e-7);
  }
}

TEST(SO3, RightJacobianMatchesTheMatrixSeries) {
  for (const Vector3d& theta : kTangents) {
    Matrix3d term = Matrix3d::Identity();
    Matrix3d sum = term;
    for (int k = 1; k < 40; ++k) sum += term = -term * skew(theta) / (k + 1);
    expect_near(SO3d::right_jacobian(theta), sum, 1e-14);
  }
}

TEST(SO3, JacobianInSinglePrecisionIsExactToRounding) {
  for (const Vector3d& theta : kTangents) {
    expect_near(SO3f::right_jacobian(theta.cast<float>()).cast<double>(),
                SO3d::right_jacobian(theta), 1e-6);
  }
}

TEST(Axial, IsTheAdjointOfSkew) {
  const Vector3d d(0.3, -1.1, 0.7);
  EXPECT_NEAR(axial(kWeights).dot(d), kWeights.cwiseProduct(skew(d)).sum(), 1e-14);
  EXPECT_NEAR(axial(kWeights * kWeights).dot(d), (kWeights * kWeights).cwiseProduct(skew(d)).sum(),
              1e-13);
}

TEST(Skew, IsTheCrossProduct) {
  const Vector3d a(1.0, -2.0, 3.0);
  const Vector3d b(-0.5, 0.7, 2.0);
  expect_near(skew(a) * b, a.cross(b), 1e-15);
}

}  // namespace
}  // namespace imslam::lie
