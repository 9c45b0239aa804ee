#pragma once

#include <vector>

#include "slam/learner/gradient_strategy.hpp"

namespace imslam::learner {

/// The implicit derivative of the KKT conditions  dL/dphi + A^T lambda = 0,  xi_active = 0:
///
///   [H A^T; A 0] [q; w] = [dU/dphi; 0]
///   dU/dz = dU/dz|direct - (d2Lagrangian/dz dphi) q - (dxi/dz)^T w
///
/// with H of the Lagrangian and A = dxi/dphi of equalities and active inequalities; the adjoint of
/// dphi/dz = H^-1 A^T (A H^-1 A^T)^-1 (A H^-1 H_phiz - A_z) - H^-1 H_phiz, but H alone may be
/// singular. An inequality is active if its multiplier is positive. With value and multiplier both
/// 0 phi* has a kink there: the gradient is that of one side, and the report counts the kinks.
class Constrained : public GradientStrategy {
 public:
  struct Options {
    double active = 1e-7;     ///< multipliers and values below count as 0
    bool hold_kinks = false;  ///< which side of a kink: on the constraint, or free of it
    double linear_tolerance = 1e-9;
  };
  Constrained(Task& task, const Convergence& convergence, const Options& options);

 private:
  void differentiate(const Vector& z, const Random& random, UpperGradient& result) override;
  std::vector<Eigen::Index> active_rows(const ConstraintValues& all, UpperGradient& result) const;
  double residual_of(const FactoredConstraints::Solution& solution,
                     const ConstraintValues& all,
                     const std::vector<Eigen::Index>& active,
                     const Vector& dphi) const;
  FactoredConstraints::Solution solve(const ConstraintValues& all,
                                      const std::vector<Eigen::Index>& active,
                                      const Vector& dphi,
                                      UpperGradient& result) const;

  LowerProblem& problem_;
  const Curvature& curvature_;
  const Constraints& constraints_;
  const UpperCost& upper_;
  Convergence convergence_;
  Options options_;
};

}  // namespace imslam::learner
