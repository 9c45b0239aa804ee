#include <gtest/gtest.h>

#include "slam/learner/implicit.hpp"
#include "slam/learner/make_strategy.hpp"
#include "tests/slam/learner/central_differences.hpp"
#include "tests/slam/learner/pose_graph_task.hpp"

namespace imslam::learner {
namespace {

using testing::expect_true_gradient;
using testing::PoseGraphTask;
using testing::relative_error;

constexpr int kPoses = 6;
constexpr double kNoise = 0.05;

StrategyOptions named(const std::string& name) {
  StrategyOptions options;
  options.strategy = name;
  options.tolerance = 1e-9;
  options.linear_tolerance = 1e-7;  // products are central differences themselves
  options.steps = 60;
  return options;
}

TEST(PoseGraph, OneStepIsTrueWhenTheUpperCostIsTheLower) {
  PoseGraphTask task(kPoses, kNoise);
  task.upper_weights = task.lower_weights;
  const auto one_step = make_strategy(named("one_step"), task);
  const double error = expect_true_gradient(*one_step, task.measured);
  const Vector gradient = (*one_step)(task.measured, Random(0)).gradient;
  const auto implicit = make_strategy(named("implicit_direct"), task);
  const double apart = relative_error((*implicit)(task.measured, Random(0)).gradient, gradient);
  EXPECT_LT(apart, 1e-9);
  std::printf("U = L: one step against differences %.1e, against implicit %.1e\n", error, apart);
}

TEST(PoseGraph, ImplicitAndUnrolledAreTrueWhenTheUpperCostIsAnother) {
  for (const char* name : {"implicit_direct", "implicit_conjugate_gradient",
                           "implicit_gradient_descent", "unrolled"}) {
    PoseGraphTask task(kPoses, kNoise);
    StrategyOptions options = named(name);
    options.linear_iterations = 20000;
    const auto strategy = make_strategy(options, task);
    const double error = expect_true_gradient(*strategy, task.measured);
    const UpperGradient upper = (*strategy)(task.measured, Random(0));
    std::printf("U != L, %-28s against differences %.1e, linear residual %.0e after %d\n", name,
                error, upper.linear.residual, upper.linear.iterations);
  }
}

// What the published method does: only visual edges in U, other weights than in L.
TEST(PoseGraph, OneStepIsWrongWhenTheUpperCostIsAnother) {
  PoseGraphTask task(kPoses, kNoise);
  const Vector exact =
      (*make_strategy(named("implicit_direct"), task))(task.measured, Random(0)).gradient;
  const Vector one_step =
      (*make_strategy(named("one_step"), task))(task.measured, Random(0)).gradient;
  const Vector direct =
      (*make_strategy(named("alternating"), task))(task.measured, Random(0)).gradient;
  std::printf("U != L: dL/dz is off by %.0f %%, dU/dz direct by %.0f %%\n",
              100.0 * relative_error(one_step, exact), 100.0 * relative_error(direct, exact));
  EXPECT_GT(relative_error(one_step, exact), 0.1);
  EXPECT_GT(relative_error(direct, exact), 0.1);
}

TEST(PoseGraph, UnrolledTendsToImplicit) {
  PoseGraphTask task(kPoses, kNoise);
  const Vector exact =
      (*make_strategy(named("implicit_direct"), task))(task.measured, Random(0)).gradient;
  double last_error = 1e9;
  for (const int steps : {2, 5, 10, 20}) {
    StrategyOptions options = named("unrolled");
    options.steps = steps;
    const auto unrolled = make_strategy(options, task);
    expect_true_gradient(*unrolled, task.measured);
    const double error = relative_error((*unrolled)(task.measured, Random(0)).gradient, exact);
    std::printf("unrolled, T = %2d: %.1e from implicit\n", steps, error);
    EXPECT_LT(error, last_error);
    last_error = error;
  }
  EXPECT_LT(last_error, 1e-4);
}

/// The pose graph with the Hessian that a solver has at hand.
class GaussNewtonTask : public PoseGraphTask {
 public:
  using PoseGraphTask::PoseGraphTask;
  Vector hessian_product(const Vector& v) const override { return gauss_newton_product(v); }
};

TEST(PoseGraph, TheHessianOfGaussNewtonGivesAsMuchErrorAsItHas) {
  PoseGraphTask exact_task(kPoses, kNoise);
  GaussNewtonTask task(kPoses, kNoise);
  const Vector exact =
      (*make_strategy(named("implicit_direct"), exact_task))(task.measured, Random(0)).gradient;
  const Vector gauss_newton =
      (*make_strategy(named("implicit_direct"), task))(task.measured, Random(0)).gradient;
  const double error = relative_error(gauss_newton, exact);
  std::printf("implicit with J^T W J: off by %.2f %%\n", 100.0 * error);
  EXPECT_LT(error, 0.1);
}

}  // namespace
}  // namespace imslam::learner
