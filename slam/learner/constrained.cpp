#include "slam/learner/constrained.hpp"

#include <cmath>

namespace imslam::learner {

using Eigen::Index;

Constrained::Constrained(Task& task, const Convergence& convergence, const Options& options)
    : problem_(required<LowerProblem>(task, "constrained", "LowerProblem")),
      curvature_(required<Curvature>(task, "constrained", "Curvature")),
      constraints_(required<Constraints>(task, "constrained", "Constraints")),
      upper_(required<UpperCost>(task, "constrained", "UpperCost")),
      convergence_(convergence),
      options_(options) {}

void Constrained::differentiate(const Vector& z, const Random&, UpperGradient& result) {
  if (!convergence_.accepts(problem_.solve(z), problem_, result)) return;
  const ConstraintValues all = constraints_.constraints();
  const std::vector<Index> active = active_rows(all, result);
  if (!result.usable()) return;
  const UpperValue upper = upper_.upper_cost();
  const FactoredConstraints::Solution adjoint = solve(all, active, upper.by_phi, result);
  if (!result.usable()) return;
  result.cost = upper.cost;
  result.gradient = upper.by_z - curvature_.mixed_product(adjoint.q);
  for (std::size_t i = 0; i < active.size(); ++i) {
    result.gradient -= adjoint.w[static_cast<Index>(i)] * all.by_z.row(active[i]).transpose();
  }
}

/// Refuses what is no solution: violated rows, multipliers that pull or that act at a distance.
std::vector<Index> Constrained::active_rows(const ConstraintValues& all,
                                            UpperGradient& result) const {
  std::vector<Index> active;
  const double zero = options_.active;
  for (Index i = 0; i < all.values.size(); ++i) {
    const double value = all.values[i];
    const double multiplier = all.multipliers[i];
    const bool equality = all.is_equality[static_cast<std::size_t>(i)] != 0;
    if (equality ? std::abs(value) > zero : value > zero) result.refusal = Refusal::kUnconverged;
    if (equality) {
      active.push_back(i);
      continue;
    }
    const bool touches = value >= -zero;
    const bool pushes = multiplier > zero;
    if (multiplier < -zero || (pushes && !touches)) result.refusal = Refusal::kMultipliers;
    const bool kink = touches && !pushes;
    if (kink) ++result.kinks;
    if (pushes || (kink && options_.hold_kinks)) active.push_back(i);
  }
  return active;
}

/// Of the system in the header, relative to dU/dphi.
double Constrained::residual_of(const FactoredConstraints::Solution& solution,
                                const ConstraintValues& all,
                                const std::vector<Index>& active,
                                const Vector& dphi) const {
  Vector upper = curvature_.hessian_product(solution.q) - dphi;
  double lower_sq = 0.0;
  for (std::size_t i = 0; i < active.size(); ++i) {
    upper += solution.w[static_cast<Index>(i)] * all.by_phi.row(active[i]).transpose();
    const double slip = all.by_phi.row(active[i]).dot(solution.q);
    lower_sq += slip * slip;
  }
  const double scale = dphi.norm();
  return scale > 0.0 ? std::sqrt(upper.squaredNorm() + lower_sq) / scale : 0.0;
}

FactoredConstraints::Solution Constrained::solve(const ConstraintValues& all,
                                                 const std::vector<Index>& active,
                                                 const Vector& dphi,
                                                 UpperGradient& result) const {
  if (const auto* const factored = dynamic_cast<const FactoredConstraints*>(&constraints_)) {
    auto solution = factored->kkt_solve(dphi, active);
    if (solution && residual_of(*solution, all, active, dphi) <= options_.linear_tolerance) {
      result.linear.iterations = 1;
      result.linear.residual = residual_of(*solution, all, active, dphi);
      return std::move(*solution);
    }
  }
  const Index n = dphi.size();
  const Index m = static_cast<Index>(active.size());
  Matrix K = Matrix::Zero(n + m, n + m);
  K.topLeftCorner(n, n) =
      matrix_of([this](const Vector& x) { return curvature_.hessian_product(x); }, n);
  for (Index i = 0; i < m; ++i) {
    K.block(n + i, 0, 1, n) = all.by_phi.row(active[static_cast<std::size_t>(i)]);
    K.block(0, n + i, n, 1) = K.block(n + i, 0, 1, n).transpose();
  }
  Vector right = Vector::Zero(n + m);
  right.head(n) = dphi;
  const LinearSolution solution = least_norm(K, right, options_.linear_tolerance);
  result.linear = solution.report;
  result.note = solution.report.reason;
  if (!solution.report.converged) result.refusal = Refusal::kLinearSolve;
  return {solution.q.head(n), solution.q.tail(m)};
}

}  // namespace imslam::learner
