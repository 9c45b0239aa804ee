#pragma once

#include <gtest/gtest.h>

#include "slam/learner/gradient_strategy.hpp"
#include "tests/support/numeric_jacobian.hpp"

namespace imslam::learner::testing {

/// d/dz of the upper cost, every probe solved anew: central differences through the whole solve.
inline Vector differences_through_solve(GradientStrategy& strategy, const Vector& z, double step) {
  const auto cost = [&](const Eigen::VectorXd& probe) -> Eigen::VectorXd {
    const UpperGradient upper = strategy(probe, Random(0));
    EXPECT_TRUE(upper.usable()) << name_of(upper.refusal) << " " << upper.residual;
    return Eigen::VectorXd::Constant(1, upper.cost);
  };
  return imslam::testing::numeric_jacobian(cost, z, step).transpose();
}

inline double relative_error(const Vector& actual, const Vector& expected) {
  return (actual - expected).norm() / expected.norm();
}

/// The law of every strategy; returns the relative error, for printing.
inline double expect_true_gradient(GradientStrategy& strategy,
                                   const Vector& z,
                                   double step = 1e-4,
                                   double tolerance = 1e-6) {
  const UpperGradient upper = strategy(z, Random(0));
  EXPECT_TRUE(upper.usable()) << name_of(upper.refusal) << " " << upper.note;
  if (!upper.usable()) return 1.0;
  const double error = relative_error(upper.gradient, differences_through_solve(strategy, z, step));
  EXPECT_LE(error, tolerance);
  return error;
}

}  // namespace imslam::learner::testing
