#include <gtest/gtest.h>

#include <Eigen/LU>

#include "slam/base/error.hpp"
#include "slam/learner/make_strategy.hpp"
#include "tests/slam/learner/central_differences.hpp"
#include "tests/slam/learner/quadratic_task.hpp"

namespace imslam::learner {
namespace {

using testing::expect_true_gradient;
using testing::QuadraticTask;
using testing::relative_error;

const Vector kZ = (Vector(2) << 0.8, -1.3).finished();

StrategyOptions named(const std::string& name) {
  StrategyOptions options;
  options.strategy = name;
  options.steps = 200;
  return options;
}

/// dU/dz = direct + B^T A^-1 (phi* - goal), by hand.
Vector known_gradient(const QuadraticTask& task) {
  const Vector phi = task.A.inverse() * task.B * kZ;
  return task.direct + task.B.transpose() * task.A.inverse() * (phi - task.goal);
}

TEST(Strategies, AllGiveTheKnownAnswerOfTheQuadratic) {
  for (const char* name : {"closed_form", "implicit_direct", "implicit_conjugate_gradient",
                           "implicit_gradient_descent", "unrolled"}) {
    QuadraticTask task;
    const auto strategy = make_strategy(named(name), task);
    const UpperGradient upper = (*strategy)(kZ, Random(0));
    ASSERT_TRUE(upper.usable()) << name << ": " << upper.note;
    EXPECT_LT(relative_error(upper.gradient, known_gradient(task)), 1e-9) << name;
    const double error = expect_true_gradient(*strategy, kZ);
    std::printf("quadratic, %-28s against differences %.1e, linear iterations %d\n", name, error,
                upper.linear.iterations);
  }
}

TEST(Strategies, OneStepIsImplicitWhenTheUpperCostIsTheLower) {
  QuadraticTask task;
  task.upper_is_lower = true;
  const auto one_step = make_strategy(named("one_step"), task);
  const auto implicit = make_strategy(named("implicit_direct"), task);
  const auto alternating = make_strategy(named("alternating"), task);
  const Vector gradient = (*one_step)(kZ, Random(0)).gradient;
  EXPECT_LT(relative_error(gradient, (*implicit)(kZ, Random(0)).gradient), 1e-12);
  EXPECT_LT(relative_error(gradient, (*alternating)(kZ, Random(0)).gradient), 1e-12);
  expect_true_gradient(*one_step, kZ);
}

TEST(Strategies, AlternatingLeavesOutExactlyTheWayThroughTheSolver) {
  QuadraticTask task;
  const auto strategy = make_strategy(named("alternating"), task);
  EXPECT_EQ((*strategy)(kZ, Random(0)).gradient, Vector(task.direct));
  task.direct.setZero();
  EXPECT_NE((*strategy)(kZ, Random(0)).note.find("learns nothing"), std::string::npos);
}

TEST(Strategies, UnrolledIsExactForTheStepsTakenAndTendsToImplicit) {
  QuadraticTask task;
  const Vector exact = known_gradient(task);
  double last_error = 1e9;
  for (const int steps : {2, 5, 10, 20, 50}) {
    StrategyOptions options = named("unrolled");
    options.steps = steps;
    const auto strategy = make_strategy(options, task);
    expect_true_gradient(*strategy, kZ);  // of what `steps` steps reach
    const double error = relative_error((*strategy)(kZ, Random(0)).gradient, exact);
    EXPECT_LT(error, last_error);
    last_error = error;
  }
  EXPECT_LT(last_error, 1e-6);
}

TEST(Strategies, TruncationErrsLessTheMoreStepsAreKept) {
  QuadraticTask task;
  const Vector exact = known_gradient(task);
  double last_error = 1e9;
  for (const int last : {1, 3, 10, 30}) {
    StrategyOptions options = named("unrolled_truncated");
    options.last = last;
    const double error =
        relative_error((*make_strategy(options, task))(kZ, Random(0)).gradient, exact);
    EXPECT_LT(error, last_error);
    last_error = error;
  }
  EXPECT_LT(last_error, 1e-3);
}

// A solver may claim what it likes: dL/dphi is looked at.
TEST(Strategies, AnUnconvergedSolveGivesNoGradient) {
  for (const char* name : {"closed_form", "one_step", "alternating", "implicit_direct"}) {
    QuadraticTask task;
    task.converges = false;
    const UpperGradient upper = (*make_strategy(named(name), task))(kZ, Random(0));
    EXPECT_EQ(upper.refusal, Refusal::kUnconverged) << name;
    EXPECT_EQ(upper.gradient.size(), 0) << name;
    EXPECT_GT(upper.residual, 0.1) << name;
    StrategyOptions lax = named(name);
    lax.tolerance = 10.0;
    EXPECT_TRUE((*make_strategy(lax, task))(kZ, Random(0)).usable()) << name;
  }
}

TEST(Strategies, WithoutAFactorConjugateGradientStepsInAndSaysSo) {
  QuadraticTask task;
  task.factor = false;
  const UpperGradient upper = (*make_strategy(named("implicit_direct"), task))(kZ, Random(0));
  ASSERT_TRUE(upper.usable());
  EXPECT_NE(upper.note.find("conjugate gradient instead"), std::string::npos) << upper.note;
  EXPECT_LT(relative_error(upper.gradient, known_gradient(task)), 1e-9);
}

TEST(Strategies, ALinearSolveThatFailsGivesNoGradient) {
  QuadraticTask task;
  for (const char* name : {"implicit_conjugate_gradient", "implicit_gradient_descent"}) {
    StrategyOptions options = named(name);
    options.linear_iterations = 1;
    const UpperGradient upper = (*make_strategy(options, task))(kZ, Random(0));
    EXPECT_EQ(upper.refusal, Refusal::kLinearSolve);
    EXPECT_FALSE(upper.note.empty());
    EXPECT_GT(upper.linear.residual, 1e-3);
  }
}

TEST(Strategies, AnUpperCostThatIsNotFiniteGivesNoGradient) {
  QuadraticTask task;
  task.direct[0] = std::nan("");
  EXPECT_EQ((*make_strategy(named("closed_form"), task))(kZ, Random(0)).refusal,
            Refusal::kNotFinite);
}

TEST(Strategies, ATaskThatLacksAnInterfaceIsToldWhich) {
  QuadraticTask task;
  try {
    make_strategy(named("constrained"), task);
    FAIL();
  } catch (const ContractError& error) {
    EXPECT_EQ(std::string(error.what()),
              "the strategy constrained needs a task that is a Constraints");
  }
  EXPECT_THROW(make_strategy(named("guessing"), task), InputError);
}

TEST(Strategies, EveryNameCanBeConfigured) {
  for (const std::string& name : strategy_names()) {
    StrategyOptions options;
    Config config;
    config.section("learner", options);
    config.set("learner.strategy=" + name, "test");
    options.validate();
    EXPECT_EQ(options.strategy, name);
  }
  StrategyOptions options;
  options.samples = 0;
  EXPECT_THROW(options.validate(), InputError);
}

}  // namespace
}  // namespace imslam::learner
