#include "slam/learner/closed_form.hpp"

namespace imslam::learner {

ClosedFormGradient::ClosedFormGradient(Task& task, const Convergence& convergence)
    : problem_(required<LowerProblem>(task, "closed_form", "LowerProblem")),
      form_(required<ClosedForm>(task, "closed_form", "ClosedForm")),
      upper_(required<UpperCost>(task, "closed_form", "UpperCost")),
      convergence_(convergence) {}

void ClosedFormGradient::differentiate(const Vector& z, const Random&, UpperGradient& result) {
  if (!convergence_.accepts(problem_.solve(z), problem_, result)) return;
  const UpperValue upper = upper_.upper_cost();
  result.cost = upper.cost;
  result.gradient = upper.by_z + form_.pull_back(upper.by_phi);
}

}  // namespace imslam::learner
