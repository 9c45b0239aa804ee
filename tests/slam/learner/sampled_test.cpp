#include <gtest/gtest.h>

#include "slam/base/parallel.hpp"
#include "slam/learner/control_variate.hpp"
#include "slam/learner/log_derivative.hpp"
#include "slam/learner/make_strategy.hpp"
#include "slam/learner/reparameterised.hpp"
#include "tests/slam/learner/sampled_tasks.hpp"
#include "tests/support/numeric_jacobian.hpp"

namespace imslam::learner {
namespace {

using testing::CoinTask;
using testing::GaussianTask;
using testing::LinearSurrogate;

constexpr int kMany = 100000;
const Vector kCoinZ = (Vector(5) << 0.4, -0.8, 0.1, 1.2, -0.3).finished();
const Vector kGaussianZ = (Vector(2) << 0.7, -0.4).finished();

Vector true_coin_gradient() {
  const CoinTask task;
  const auto mean = [&](const Eigen::VectorXd& z) -> Eigen::VectorXd {
    return Vector::Constant(1, task.expected_cost(z));
  };
  return imslam::testing::numeric_jacobian(mean, kCoinZ).transpose();
}

/// Within four standard errors of the truth, all coordinates together.
void expect_unbiased(const UpperGradient& upper, const Vector& truth, const char* what) {
  ASSERT_TRUE(upper.usable());
  const double standard_error = std::sqrt(upper.variance / upper.samples);
  const double error = (upper.gradient - truth).norm();
  std::printf("%-32s off by %.4f, standard error %.4f, variance %.3f\n", what, error,
              standard_error, upper.variance);
  EXPECT_LT(error, 4.0 * standard_error);
  EXPECT_LT(standard_error, 0.1);
}

UpperGradient many(GradientStrategy&& strategy, const Vector& z) { return strategy(z, Random(3)); }

TEST(LogDerivative, IsUnbiasedAndTheBaselineTakesVarianceAway) {
  CoinTask task;
  const Vector truth = true_coin_gradient();
  const UpperGradient plain = many(LogDerivative(task, {kMany, false}), kCoinZ);
  const UpperGradient based = many(LogDerivative(task, {kMany, true}), kCoinZ);
  expect_unbiased(plain, truth, "log derivative");
  expect_unbiased(based, truth, "log derivative with baseline");
  EXPECT_NEAR(plain.cost, task.expected_cost(kCoinZ), 0.05);
  EXPECT_LT(based.variance, 0.2 * plain.variance);
}

// With 16 draws the baseline depends on them, but for each on the others only.
TEST(LogDerivative, TheBaselineOfFewDrawsBiasesNothing) {
  CoinTask task;
  LogDerivative strategy(task, {4, true});
  Vector mean = Vector::Zero(5);
  double variance = 0.0;
  constexpr int kRepeats = 20000;
  const Vector truth = true_coin_gradient();
  for (int i = 0; i < kRepeats; ++i) {
    const Vector g = strategy(kCoinZ, Random(17).fork(static_cast<std::uint64_t>(i))).gradient;
    mean += g / kRepeats;
    variance += (g - truth).squaredNorm() / kRepeats;
  }
  EXPECT_LT((mean - truth).norm(), 4.0 * std::sqrt(variance / kRepeats));
}

TEST(ControlVariate, LearnsToTakeVarianceAwayAndStaysUnbiased) {
  CoinTask task;
  LinearSurrogate surrogate;
  const UpperGradient plain = many(ControlVariate(task, surrogate, {kMany}), kCoinZ);
  ControlVariate strategy(task, surrogate, {64});
  for (std::uint64_t i = 0; i < 400; ++i) {
    strategy(kCoinZ, Random(9).fork(i));
    strategy.teach(surrogate);
    surrogate.step();
  }
  const UpperGradient learned = many(ControlVariate(task, surrogate, {kMany}), kCoinZ);
  const UpperGradient based = many(LogDerivative(task, {kMany, true}), kCoinZ);
  const Vector truth = true_coin_gradient();
  expect_unbiased(plain, truth, "control variate, untaught");
  expect_unbiased(learned, truth, "control variate, taught");
  std::printf("variance: log derivative / control variate = %.1f, with baseline / it = %.1f\n",
              plain.variance / learned.variance, based.variance / learned.variance);
  EXPECT_LT(learned.variance, 0.5 * based.variance);
}

TEST(ControlVariate, TheLessonIsTheSlopeOfTheMeanSquareOfTheGradient) {
  CoinTask task;
  LinearSurrogate surrogate;
  surrogate.gamma << 3.0, 0.5, -0.2, 0.8, 0.1, -0.6;
  const auto mean_square = [&](const Eigen::VectorXd& gamma) -> Eigen::VectorXd {
    LinearSurrogate probe;
    probe.gamma = gamma;
    const UpperGradient upper = many(ControlVariate(task, probe, {50}), kCoinZ);
    return Vector::Constant(1, upper.variance * 49.0 / 50.0 + upper.gradient.squaredNorm());
  };
  ControlVariate strategy(task, surrogate, {50});
  strategy(kCoinZ, Random(3));
  strategy.teach(surrogate);
  imslam::testing::expect_near(
      surrogate.gradient.transpose(),
      imslam::testing::numeric_jacobian(mean_square, surrogate.gamma, 1e-4), 1e-8);
}

TEST(ControlVariate, WithABaselineItIsUnbiasedAndItsLessonIsStillTheSlope) {
  CoinTask task;
  LinearSurrogate surrogate;
  surrogate.gamma << 3.0, 0.5, -0.2, 0.8, 0.1, -0.6;
  const UpperGradient based = many(ControlVariate(task, surrogate, {kMany, true}), kCoinZ);
  expect_unbiased(based, true_coin_gradient(), "control variate with baseline");
  const auto mean_square = [&](const Eigen::VectorXd& gamma) -> Eigen::VectorXd {
    LinearSurrogate probe;
    probe.gamma = gamma;
    const UpperGradient upper = many(ControlVariate(task, probe, {50, true}), kCoinZ);
    return Vector::Constant(1, upper.variance * 49.0 / 50.0 + upper.gradient.squaredNorm());
  };
  ControlVariate strategy(task, surrogate, {50, true});
  strategy(kCoinZ, Random(3));
  strategy.teach(surrogate);
  imslam::testing::expect_near(
      surrogate.gradient.transpose(),
      imslam::testing::numeric_jacobian(mean_square, surrogate.gamma, 1e-4), 1e-8);
}

TEST(Reparameterised, IsUnbiasedWithLessVarianceThanTheLogDerivative) {
  GaussianTask task;
  const Vector truth = task.expected_slope(kGaussianZ);
  const UpperGradient path = many(Reparameterised(task, {kMany}), kGaussianZ);
  const UpperGradient score = many(LogDerivative(task, {kMany, true}), kGaussianZ);
  expect_unbiased(path, truth, "reparameterised");
  expect_unbiased(score, truth, "log derivative of the same");
  std::printf("variance: log derivative / reparameterised = %.1f\n",
              score.variance / path.variance);
  EXPECT_LT(path.variance, score.variance);
}

TEST(SampledStrategies, ThreadsDoNotChangeABit) {
  CoinTask coins;
  GaussianTask gaussian;
  LinearSurrogate surrogate;
  surrogate.gamma.setConstant(0.3);
  const auto run = [&](int threads) {
    set_thread_count(threads);
    Vector all(12);
    all << many(LogDerivative(coins, {500, true}), kCoinZ).gradient,
        many(ControlVariate(coins, surrogate, {500}), kCoinZ).gradient,
        many(Reparameterised(gaussian, {500}), kGaussianZ).gradient;
    set_thread_count(0);
    return all;
  };
  EXPECT_EQ(run(1), run(2));
}

TEST(SampledStrategies, DrawsThatDoNotConvergeAreLeftOutAndCounted) {
  CoinTask task;
  task.never_converges_above = 11.0;
  const UpperGradient some = many(LogDerivative(task, {100, true}), kCoinZ);
  ASSERT_TRUE(some.usable());
  EXPECT_LT(some.samples, 100);
  EXPECT_GT(some.samples, 0);
  EXPECT_NE(some.note.find("did not converge"), std::string::npos);
  task.never_converges_above = -1.0;
  EXPECT_EQ(many(LogDerivative(task, {100, true}), kCoinZ).refusal, Refusal::kUnconverged);
}

TEST(SampledStrategies, AreMadeByName) {
  CoinTask coins;
  GaussianTask gaussian;
  LinearSurrogate surrogate;
  StrategyOptions options;
  for (const char* name : {"log_derivative", "reparameterised", "control_variate"}) {
    options.strategy = name;
    Task& task = options.strategy == "reparameterised" ? static_cast<Task&>(gaussian) : coins;
    const Vector& z = options.strategy == "reparameterised" ? kGaussianZ : kCoinZ;
    EXPECT_TRUE((*make_strategy(options, task, &surrogate))(z, Random(1)).usable()) << name;
  }
}

}  // namespace
}  // namespace imslam::learner
