#include "slam/plugins/routing/allocation_improvement.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "slam/learner/alternating.hpp"
#include "tests/support/numeric_jacobian.hpp"

namespace imslam::routing {
namespace {

using learner::Vector;

constexpr int kAgents = 3;
constexpr int kCities = 40;

AllocationProblem some_problem() {
  Random random(31);
  AllocationProblem problem(kAgents);
  problem.set_instance(random_instance(kCities, random));
  return problem;
}

Vector some_logits() {
  Random random(32);
  Vector z((kCities - 1) * kAgents);
  for (double& value : z) value = random.normal();
  return z;
}

Vector as_draw(const std::vector<int>& agent_of) {
  Vector x(static_cast<Eigen::Index>(agent_of.size()));
  for (std::size_t i = 0; i < agent_of.size(); ++i) {
    x[static_cast<Eigen::Index>(i)] = agent_of[i];
  }
  return x;
}

TEST(AllocationImprovement, ShortensTheLongestTourOfTheLikeliestAllocation) {
  const AllocationProblem problem = some_problem();
  AllocationImprovement improvement(problem, 20.0);
  const SolveReport report = improvement.solve(some_logits());
  EXPECT_LT(report.cost, 0.7 * report.initial_cost);
  EXPECT_NEAR(*problem.cost(as_draw(improvement.agent_of())), report.cost, 0.1 * report.cost);
}

TEST(AllocationImprovement, ItsGradientIsTheSlopeOfTheCostWithTheAllocationHeld) {
  const AllocationProblem problem = some_problem();
  AllocationImprovement improvement(problem, 5.0);
  const Vector z = some_logits();
  learner::Alternating strategy(improvement, learner::Convergence());
  const learner::UpperGradient upper = strategy(z, Random(1));
  ASSERT_TRUE(upper.usable());
  const std::vector<int> taught = improvement.agent_of();
  const auto cost = [&](const Eigen::VectorXd& at) -> Eigen::VectorXd {
    const learner::Matrix p = allocation_probabilities(at, kAgents);
    double sum = 0.0;
    for (Eigen::Index i = 0; i < p.rows(); ++i) {
      sum -= std::log(p(i, taught[static_cast<std::size_t>(i)])) / static_cast<double>(p.rows());
    }
    return Vector::Constant(1, sum);
  };
  EXPECT_NEAR(upper.cost, cost(z)[0], 1e-12);
  imslam::testing::expect_near(upper.gradient.transpose(),
                               imslam::testing::numeric_jacobian(cost, z), 1e-7);
}

}  // namespace
}  // namespace imslam::routing
