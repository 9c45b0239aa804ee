#include "slam/plugins/routing/allocation_improvement.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "slam/learner/alternating.hpp"
#include "slam/plugins/routing/allocate.hpp"
#include "slam/plugins/routing/min_max_search.hpp"
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

/// Logits of a network that shares out as told.
Vector logits_of(const std::vector<int>& agent_of) {
  Vector z = Vector::Zero(static_cast<Eigen::Index>(agent_of.size()) * kAgents);
  for (std::size_t i = 0; i < agent_of.size(); ++i) {
    z[static_cast<Eigen::Index>(i) * kAgents + agent_of[i]] = 3.0;
  }
  return z;
}

double share_alike(const std::vector<int>& a, const std::vector<int>& b) {
  double alike = 0.0;
  for (std::size_t i = 0; i < a.size(); ++i) alike += a[i] == b[i] ? 1.0 : 0.0;
  return alike / static_cast<double>(a.size());
}

TEST(AllocationImprovement, IsAtLeastAsGoodAsInsertion) {
  const AllocationProblem problem = some_problem();
  const Distances distances(problem.instance());
  const Neighbours near(distances, kCities - 1);
  const Fleet inserted =
      MinMaxSearch::greedy(Fleet(distances, problem.instance().depot, kAgents), near);
  AllocationImprovement improvement(problem, 20.0);
  const SolveReport report = improvement.solve(some_logits());
  EXPECT_LE(report.cost, inserted.length(inserted.longest()));
  EXPECT_LT(report.cost, 0.6 * report.initial_cost);
}

TEST(AllocationImprovement, ItsCostIsThatOfTheAllocationThatItTeaches) {
  const AllocationProblem problem = some_problem();
  AllocationImprovement improvement(problem, 20.0);
  const Vector z = some_logits();
  const SolveReport report = improvement.solve(z);
  EXPECT_NEAR(*problem.cost(likeliest_allocation(z, kAgents)), report.initial_cost, 1e-4);
  EXPECT_NEAR(*problem.cost(as_draw(improvement.agent_of())), report.cost, 0.01 * report.cost);
}

TEST(AllocationImprovement, LeavesAGoodAllocationItsNumbers) {
  const AllocationProblem problem = some_problem();
  AllocationImprovement improvement(problem, 200.0);
  improvement.solve(some_logits());
  std::vector<int> turned = improvement.agent_of();  // good, under numbers of its own
  for (int& agent : turned) agent = (agent + 1) % kAgents;
  AllocationImprovement again(problem, 5.0);
  again.solve(logits_of(turned));
  EXPECT_GE(share_alike(again.agent_of(), turned), 0.9);
}

TEST(AllocationImprovement, BringsACityInAnothersRegionBack) {
  const AllocationProblem problem = some_problem();
  AllocationImprovement improvement(problem, 200.0);
  improvement.solve(some_logits());
  const std::vector<int> good = improvement.agent_of();
  const double shortest = *problem.cost(as_draw(good));
  int costly = 0, brought_back = 0;
  for (std::size_t city = 0; city < good.size(); ++city) {
    std::vector<int> spoilt = good;
    spoilt[city] = (good[city] + 1) % kAgents;
    if (*problem.cost(as_draw(spoilt)) < 1.05 * shortest) continue;  // as well off there
    ++costly;
    AllocationImprovement again(problem, 5.0);
    again.solve(logits_of(spoilt));
    if (again.agent_of()[city] == good[city]) ++brought_back;
  }
  EXPECT_GE(costly, 10);
  EXPECT_GE(brought_back, 9 * costly / 10);
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
