#pragma once

#include <vector>

#include "slam/learner/lower_problem.hpp"
#include "slam/plugins/routing/allocation_problem.hpp"

namespace imslam::routing {

/// The network's answer, bettered by a search that starts from it, as a lower level:
///
///   phi* = search(likeliest allocation of z)        U = -1/n sum_i log p(city i to phi*_i | z)
///
/// The search moves cities between the network's own tours, so that phi* keeps their numbers. What
/// it moves alike in many instances (regions too large, borders in the wrong place) the network
/// learns; what it moves by chance averages out. One label per city instead of one cost per draw:
/// next to no variance, but it climbs the search's hill, not the gradient of the longest tour.
class AllocationImprovement : public learner::LowerProblem, public learner::UpperCost {
 public:
  /// `effort`: iterations of the search per city. The problem must outlive it.
  AllocationImprovement(const AllocationProblem& problem, double effort)
      : problem_(problem), effort_(effort) {}

  SolveReport solve(const learner::Vector& z) override;
  learner::UpperValue upper_cost() const override;
  const std::vector<int>& agent_of() const { return agent_of_; }  ///< of all but the depot

 private:
  const AllocationProblem& problem_;
  double effort_;
  learner::Vector z_;
  std::vector<int> agent_of_;
};

}  // namespace imslam::routing
