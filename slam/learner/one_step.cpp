#include "slam/learner/one_step.hpp"

namespace imslam::learner {

OneStep::OneStep(Task& task, const Convergence& convergence)
    : problem_(required<LowerProblem>(task, "one_step", "LowerProblem")),
      cost_(required<StationaryCost>(task, "one_step", "StationaryCost")),
      convergence_(convergence) {}

void OneStep::differentiate(const Vector& z, const Random&, UpperGradient& result) {
  if (!convergence_.accepts(problem_.solve(z), problem_, result)) return;
  result.cost = cost_.cost();
  result.gradient = cost_.cost_by_z();
}

}  // namespace imslam::learner
