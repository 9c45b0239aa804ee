#include "slam/learner/unrolled.hpp"

#include <algorithm>
#include <vector>

namespace imslam::learner {

Unrolled::Unrolled(Task& task, const Options& options)
    : solver_(required<SolverSteps>(task, "unrolled", "SolverSteps")),
      upper_(required<UpperCost>(task, "unrolled", "UpperCost")),
      options_(options) {}

void Unrolled::differentiate(const Vector& z, const Random&, UpperGradient& result) {
  const int kept = options_.last > 0 ? std::min(options_.last, options_.steps) : options_.steps;
  std::vector<Vector> states;  // before each kept step
  Vector phi = solver_.first_guess();
  for (int t = 0; t < options_.steps; ++t) {
    Vector next = solver_.step(phi, z);
    if (t >= options_.steps - kept) states.push_back(std::move(phi));
    phi = std::move(next);
  }
  const SolveReport report = solver_.adopt(phi, z);
  result.solve = report;
  result.residual = report.gradient_norm;
  if (options_.tolerance > 0.0 &&
      !Convergence{options_.tolerance}.accepts(report, solver_, result)) {
    return;
  }
  const UpperValue upper = upper_.upper_cost();
  result.cost = upper.cost;
  result.gradient = upper.by_z;
  Vector dphi = upper.by_phi;
  for (auto state = states.rbegin(); state != states.rend(); ++state) {
    SolverSteps::StepGradient back = solver_.pull_back(*state, z, dphi);
    result.gradient += back.by_z;
    dphi = std::move(back.by_phi);
  }
}

}  // namespace imslam::learner
