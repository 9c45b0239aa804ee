#include "pgo/robust_loss.hpp"

#include <gtest/gtest.h>

#include <cmath>

namespace imslam::pgo {
namespace {

TEST(CauchyTailLoss, LeavesWhatFitsAlone) {
  const CauchyTailLoss loss(3.0);
  for (const double s : {0.0, 1.0, 6.0, 8.99}) {
    double rho[3];
    loss.Evaluate(s, rho);
    EXPECT_EQ(rho[0], s);
    EXPECT_EQ(rho[1], 1.0);
    EXPECT_EQ(rho[2], 0.0);
  }
}

TEST(CauchyTailLoss, DerivativesMatchCentralDifferences) {
  const CauchyTailLoss loss(3.0);
  for (const double s : {2.0, 9.5, 20.0, 1e4}) {
    const double h = 1e-5 * s;
    double below[3];
    double at[3];
    double above[3];
    loss.Evaluate(s - h, below);
    loss.Evaluate(s, at);
    loss.Evaluate(s + h, above);
    EXPECT_NEAR(at[1], (above[0] - below[0]) / (2.0 * h), 1e-8);
    EXPECT_NEAR(at[2], (above[1] - below[1]) / (2.0 * h), 1e-8);
  }
}

TEST(CauchyTailLoss, HasNoStepInValueAndWeightAtItsWidth) {
  const CauchyTailLoss loss(4.0);
  double inside[3];
  double outside[3];
  loss.Evaluate(16.0, inside);
  loss.Evaluate(std::nextafter(16.0, 17.0), outside);
  EXPECT_NEAR(outside[0], inside[0], 1e-12);
  EXPECT_NEAR(outside[1], inside[1], 1e-12);
}

TEST(CauchyTailLoss, PullsLessThanHubersFarOutAsMuchAsCauchys) {
  GraphOptions options;
  const auto weight = [&options](const char* kernel, double s) {
    options.kernel = kernel;
    return robust_cost(make_loss(options).get(), s).slope;
  };
  constexpr double kFarOut = 1e4;
  EXPECT_NEAR(weight("cauchy_tail", kFarOut) / weight("cauchy", kFarOut), 1.0, 0.01);
  EXPECT_LT(weight("cauchy_tail", kFarOut), 0.1 * weight("huber", kFarOut));
  EXPECT_LT(weight("cauchy", 6.0), 0.8);  // that is why
  EXPECT_EQ(weight("none", kFarOut), 1.0);
}

}  // namespace
}  // namespace imslam::pgo
