#include "slam/learner/implicit.hpp"

namespace imslam::learner {

Implicit::Implicit(Task& task,
                   const Convergence& convergence,
                   Method method,
                   const LinearOptions& linear)
    : problem_(required<LowerProblem>(task, "implicit", "LowerProblem")),
      curvature_(required<Curvature>(task, "implicit", "Curvature")),
      upper_(required<UpperCost>(task, "implicit", "UpperCost")),
      convergence_(convergence),
      method_(method),
      linear_(linear) {}

void Implicit::differentiate(const Vector& z, const Random&, UpperGradient& result) {
  if (!convergence_.accepts(problem_.solve(z), problem_, result)) return;
  const UpperValue upper = upper_.upper_cost();
  const LinearSolution solution = solve(upper.by_phi);
  result.linear = solution.report;
  result.note = solution.report.reason;
  if (!solution.report.converged) {
    result.refusal = Refusal::kLinearSolve;
    return;
  }
  result.cost = upper.cost;
  result.gradient = upper.by_z - curvature_.mixed_product(solution.q);
}

LinearSolution Implicit::solve(const Vector& v) const {
  const MatrixProduct H = [this](const Vector& x) { return curvature_.hessian_product(x); };
  switch (method_) {
    case Method::kConjugateGradient:
      return conjugate_gradient(H, v, linear_);
    case Method::kGradientDescent:
      return gradient_descent(H, v, linear_);
    case Method::kDirect:
      break;
  }
  return solve_directly(H, v);
}

LinearSolution Implicit::solve_directly(const MatrixProduct& H, const Vector& v) const {
  const auto* const factored = dynamic_cast<const FactoredCurvature*>(&curvature_);
  if (factored == nullptr) return least_norm(matrix_of(H, v.size()), v, linear_.tolerance);
  if (const std::optional<Vector> q = factored->hessian_solve(v)) {
    const double scale = v.norm();
    const double residual = scale > 0.0 ? (H(*q) - v).norm() / scale : 0.0;
    if (residual <= linear_.tolerance) return {*q, {true, 1, residual, ""}};
  }
  LinearSolution fallback = conjugate_gradient(H, v, linear_);
  fallback.report.reason = fallback.report.converged
                               ? "no use in the factor: conjugate gradient instead"
                               : "no use in the factor; " + fallback.report.reason;
  return fallback;
}

}  // namespace imslam::learner
