#pragma once

#include <vector>

#include "slam/learner/sampled_problem.hpp"
#include "slam/plugins/routing/instance.hpp"
#include "slam/plugins/routing/tour_solver.hpp"

namespace imslam::routing {

/// P(city i to agent j) = softmax_j z_ij.   z: (n - 1) x agents row by row, the depot left out.
learner::Matrix allocation_probabilities(const learner::Vector& z, int agents);

/// Cities shared out: one list per agent, the depot first. `agent_of`: of all but the depot.
std::vector<std::vector<int>> shares_of(const Instance& instance,
                                        const std::vector<int>& agent_of,
                                        int agents);

/// The min-max multiple travelling salesman as a discrete lower level:
///
///   z   logits of who visits whom    x ~ p(.|z)   one agent per city, cities independent
///   L(x) = length of the longest of the agents' tours, each by solve_tour()
class AllocationProblem : public learner::SampledProblem {
 public:
  explicit AllocationProblem(int agents) : agents_(agents) {}

  void set_instance(Instance instance);
  const Instance& instance() const { return instance_; }
  int agents() const { return agents_; }

  learner::Vector draw(const learner::Vector& z, Random& random) const override;
  std::optional<double> cost(const learner::Vector& x) const override;
  learner::Vector score(const learner::Vector& x, const learner::Vector& z) const override;

 private:
  int agents_;
  Instance instance_;
  bool symmetric_ = true;
};

}  // namespace imslam::routing
