#include "slam/learner/alternating.hpp"

namespace imslam::learner {

Alternating::Alternating(Task& task, const Convergence& convergence)
    : problem_(required<LowerProblem>(task, "alternating", "LowerProblem")),
      upper_(required<UpperCost>(task, "alternating", "UpperCost")),
      convergence_(convergence) {}

void Alternating::differentiate(const Vector& z, const Random&, UpperGradient& result) {
  if (!convergence_.accepts(problem_.solve(z), problem_, result)) return;
  UpperValue upper = upper_.upper_cost();
  if (upper.by_z.isZero(0.0) && !upper.by_phi.isZero(0.0)) {
    result.note = "U depends on z through phi only: alternating learns nothing";
  }
  result.cost = upper.cost;
  result.gradient = std::move(upper.by_z);
}

}  // namespace imslam::learner
