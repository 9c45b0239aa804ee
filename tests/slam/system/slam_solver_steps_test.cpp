#include "slam/system/slam_solver_steps.hpp"

#include <gtest/gtest.h>

#include "slam/learner/unrolled.hpp"
#include "tests/slam/system/contradictory_graph.hpp"

namespace imslam::system {
namespace {

using learner::Vector;

SlamSolverSteps steps_of(pgo::PoseVelocityGraph graph) {
  pgo::GraphOptions options = graph.options();
  options.estimate_gravity = false;
  SlamUpperOptions upper;
  upper.kind = UpperKind::kPublished;
  return SlamSolverSteps(graph.data(), options, upper);
}

TEST(SlamSolverSteps, UnrolledIsTrueForFewStepsAndTendsToImplicitForMany) {
  SlamSolverSteps task = steps_of(testing::contradictory_graph(6, true));
  const Vector z = task.coordinates().origin();
  learner::Unrolled few(task, {3, 0, 0.0});
  const Vector gradient = few(z, Random(0)).gradient;
  Random random(4);
  for (int i = 0; i < 10; ++i) {
    Vector direction(z.size());
    for (double& x : direction) x = random.normal();
    constexpr double kStep = 1e-5;
    const double numeric =
        (few(z + kStep * direction, Random(0)).cost - few(z - kStep * direction, Random(0)).cost) /
        (2.0 * kStep);
    EXPECT_NEAR(gradient.dot(direction), numeric, 1e-6 * gradient.norm());
  }
  learner::Unrolled many(task, {40, 0, 0.0});
  const Vector unrolled = many(z, Random(0)).gradient;
  ASSERT_TRUE(task.solve(z).converged);
  const learner::UpperValue upper = task.upper_cost();
  const auto q = task.hessian_solve(upper.by_phi);
  ASSERT_TRUE(q);
  const Vector implicit = upper.by_z - task.mixed_product(*q);
  std::printf("unrolled beside implicit: 3 steps %.1e, 40 steps %.1e\n",
              (gradient - implicit).norm() / implicit.norm(),
              (unrolled - implicit).norm() / implicit.norm());
  EXPECT_LT((unrolled - implicit).norm(), 1e-6 * implicit.norm());
}

}  // namespace
}  // namespace imslam::system
