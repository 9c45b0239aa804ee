#include "slam/learner/constrained.hpp"

#include <gtest/gtest.h>

#include "tests/slam/learner/central_differences.hpp"
#include "tests/slam/learner/constrained_task.hpp"

namespace imslam::learner {
namespace {

using testing::ConstrainedTask;
using testing::differences_through_solve;
using testing::expect_true_gradient;
using testing::relative_error;

const Vector kFree = (Vector(2) << 0.9, 1.4).finished();  // phi_2 < z_1
const Vector kHeld = (Vector(2) << 1.2, 0.1).finished();  // phi_2 = z_1
constexpr Convergence kConvergence{1e-9};

TEST(Constrained, EqualityGivesTheTrueGradient) {
  ConstrainedTask task;
  Constrained strategy(task, kConvergence, {});
  const double error = expect_true_gradient(strategy, kFree);
  ASSERT_FALSE(task.held());
  std::printf("equality: against differences %.1e\n", error);
}

TEST(Constrained, AnActiveInequalityGivesTheTrueGradient) {
  ConstrainedTask task;
  Constrained strategy(task, kConvergence, {});
  const double error = expect_true_gradient(strategy, kHeld);
  ASSERT_TRUE(task.held());
  EXPECT_EQ(strategy(kHeld, Random(0)).kinks, 0);
  std::printf("active inequality: against differences %.1e\n", error);
}

TEST(Constrained, TheTasksOwnFactorGivesTheSame) {
  for (const Vector& z : {kFree, kHeld}) {
    ConstrainedTask task;
    Constrained strategy(task, kConvergence, {});
    const Vector dense = strategy(z, Random(0)).gradient;
    task.factor = true;
    const UpperGradient factored = strategy(z, Random(0));
    EXPECT_LT(relative_error(factored.gradient, dense), 1e-10);
    EXPECT_LT(factored.linear.residual, 1e-10);
  }
}

TEST(Constrained, AConstraintStatedTwiceIsSolvedAndReported) {
  ConstrainedTask task;
  Constrained strategy(task, kConvergence, {});
  const Vector once = strategy(kFree, Random(0)).gradient;
  task.twice = true;
  const UpperGradient twice = strategy(kFree, Random(0));
  ASSERT_TRUE(twice.usable());
  EXPECT_NE(twice.note.find("singular"), std::string::npos);
  EXPECT_LT(relative_error(twice.gradient, once), 1e-9);
}

TEST(Constrained, AMultiplierThatPullsIsRefused) {
  ConstrainedTask task;
  task.wrong_sign = true;
  Constrained strategy(task, kConvergence, {});
  EXPECT_EQ(strategy(kHeld, Random(0)).refusal, Refusal::kMultipliers);
}

/// z_1 at which the inequality is just about to bite: there phi* has a kink.
Vector at_the_kink(Constrained& strategy, const ConstrainedTask& task) {
  Vector free = kFree;
  Vector held = kFree;
  held[1] = 0.1;
  for (int i = 0; i < 60; ++i) {
    const Vector middle = 0.5 * (free + held);
    strategy(middle, Random(0));
    (task.held() ? held : free) = middle;
  }
  return free;
}

TEST(Constrained, AtAKinkTheGradientIsThatOfTheChosenSide) {
  ConstrainedTask task;
  Constrained free_side(task, kConvergence, {});
  Constrained::Options options;
  options.hold_kinks = true;
  Constrained held_side(task, kConvergence, options);
  const Vector z = at_the_kink(free_side, task);
  const UpperGradient free = free_side(z, Random(0));
  const UpperGradient held = held_side(z, Random(0));
  ASSERT_TRUE(free.usable() && held.usable());
  EXPECT_EQ(free.kinks, 1);
  EXPECT_EQ(held.kinks, 1);
  EXPECT_GT(relative_error(free.gradient, held.gradient), 0.05);
  const Vector off = 1e-3 * Vector::Unit(2, 1);  // far enough for differences of step 1e-4
  EXPECT_LT(relative_error(free.gradient, free_side(z + off, Random(0)).gradient), 0.01);
  EXPECT_LT(relative_error(held.gradient, free_side(z - off, Random(0)).gradient), 0.01);
}

}  // namespace
}  // namespace imslam::learner
