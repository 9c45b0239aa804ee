#include "slam/learner/gradient_strategy.hpp"

#include <cmath>

namespace imslam::learner {

std::string_view name_of(Refusal refusal) {
  switch (refusal) {
    case Refusal::kNone:
      return "none";
    case Refusal::kUnconverged:
      return "unconverged solve";
    case Refusal::kLinearSolve:
      return "unsolved linear system";
    case Refusal::kMultipliers:
      return "multipliers of the wrong sign";
    case Refusal::kNotFinite:
      return "not finite";
  }
  return "";
}

UpperGradient GradientStrategy::operator()(const Vector& z, const Random& random) {
  UpperGradient result;
  differentiate(z, random, result);
  if (result.usable() && !(std::isfinite(result.cost) && result.gradient.allFinite())) {
    result.refusal = Refusal::kNotFinite;
  }
  if (!result.usable()) result.gradient.resize(0);
  expects(!result.usable() || result.gradient.size() == z.size(),
          "GradientStrategy: dU/dz must be as long as z");
  return result;
}

bool Convergence::accepts(const SolveReport& report,
                          const Task& task,
                          UpperGradient& result) const {
  result.solve = report;
  result.residual = report.gradient_norm;
  const auto* const cost = dynamic_cast<const StationaryCost*>(&task);
  const bool constrained = dynamic_cast<const Constraints*>(&task) != nullptr;
  // With constraints dL/dphi is balanced by multipliers: only the solver knows the Lagrangian's.
  if (report.converged && cost != nullptr && !constrained) {
    result.residual = cost->cost_by_phi().lpNorm<Eigen::Infinity>();
  }
  if (report.converged && result.residual <= tolerance) return true;
  result.refusal = Refusal::kUnconverged;
  return false;
}

}  // namespace imslam::learner
