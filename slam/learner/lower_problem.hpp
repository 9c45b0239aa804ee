#pragma once

#include <Eigen/Core>
#include <optional>
#include <vector>

#include "slam/base/solve_report.hpp"

namespace imslam::learner {

using Vector = Eigen::VectorXd;
using Matrix = Eigen::MatrixXd;

// The lower level of a bilevel problem, and all that a task may offer about it:
//
//   min_theta U(z, phi*)      z = f(theta, x)                 upper level: a network says z
//   s.t. phi* = argmin_phi L(phi, z),  xi(phi, z) = 0 or <= 0 lower level: a solver moves phi
//
// A task is a class that inherits those of these interfaces that it can offer; a gradient strategy
// asks for those that it needs (make_strategy.hpp):
//
//   closed_form    LowerProblem, UpperCost, ClosedForm
//   one_step       LowerProblem, StationaryCost
//   implicit       LowerProblem, UpperCost, Curvature (FactoredCurvature, if there is a factor)
//   unrolled       SolverSteps, UpperCost
//   constrained    LowerProblem, UpperCost, Curvature, Constraints (FactoredConstraints likewise)
//   alternating    LowerProblem, UpperCost
//
// Everything is asked at the (phi, z) of the last solve(z), or adopt(phi, z). phi may live on a
// manifold: then d/dphi is with respect to the right perturbation phi Exp(tau) in the tangent space
// at phi, dphi and q are tangents, and H is symmetric only where dL/dphi = 0. Likewise d/dz is with
// respect to whatever z the network says. A task serves one thread; samples that run side by side
// have a task each.

/// Root of the interfaces: names a task whatever it offers.
class Task {
 public:
  virtual ~Task() = default;
};

class LowerProblem : public virtual Task {
 public:
  /// Moves phi to phi*(z). Never throws for numerical reasons: an unconverged report is enough, the
  /// learner then takes no gradient. `gradient_norm` is the largest entry of dL/dphi there (of the
  /// Lagrangian, if there are constraints); a closed form reports 0.
  virtual SolveReport solve(const Vector& z) = 0;
};

/// L and its slopes, for U = L.
class StationaryCost : public virtual Task {
 public:
  virtual double cost() const = 0;         ///< L(phi, z)
  virtual Vector cost_by_z() const = 0;    ///< dL/dz, phi held
  virtual Vector cost_by_phi() const = 0;  ///< dL/dphi: 0 at a solution, the learner looks itself
};

/// U and its slopes with respect to each argument, the other one held.
struct UpperValue {
  double cost = 0.0;
  Vector by_z;    ///< dU/dz direct
  Vector by_phi;  ///< dU/dphi
};

class UpperCost : public virtual Task {
 public:
  virtual UpperValue upper_cost() const = 0;
};

/// phi*(z) as a formula that can be differentiated, or a straight-through stand-in for it.
class ClosedForm : public virtual Task {
 public:
  virtual Vector pull_back(const Vector& dphi) const = 0;  ///< (dphi*/dz)^T dphi
};

/// Second derivatives of L as products; of the Lagrangian L + lambda^T xi if there are constraints,
/// lambda held. H may be that of Gauss-Newton: then gradients are as inexact as it is.
class Curvature : public virtual Task {
 public:
  virtual Vector hessian_product(const Vector& v) const = 0;  ///< H v,  H = d2L/dphi2
  virtual Vector mixed_product(const Vector& v) const = 0;    ///< (d2L/dz dphi) v, as long as z
};

/// For solvers that have factored H (undamped) anyway.
class FactoredCurvature : public Curvature {
 public:
  virtual std::optional<Vector> hessian_solve(const Vector& v) const = 0;  ///< empty: singular
};

/// All constraints at the solution; rows in a fixed order, equalities and inequalities mixed.
struct ConstraintValues {
  Vector values;       ///< xi: = 0, or <= 0
  Vector multipliers;  ///< lambda of the Lagrangian L + lambda^T xi; >= 0 for inequalities
  std::vector<char> is_equality;  ///< row by row
  Matrix by_phi;                  ///< A = dxi/dphi
  Matrix by_z;                    ///< dxi/dz
};

class Constraints : public virtual Task {
 public:
  virtual ConstraintValues constraints() const = 0;
};

/// For solvers with a factor of their own (e.g. Riccati) for
///
///   [H A^T; A 0] [q; w] = [dphi; 0],   A: the rows listed in `active`
class FactoredConstraints : public Constraints {
 public:
  struct Solution {
    Vector q;  ///< as long as phi
    Vector w;  ///< as long as `active`
  };
  virtual std::optional<Solution> kkt_solve(const Vector& dphi,
                                            const std::vector<Eigen::Index>& active) const = 0;
};

/// phi_{t+1} = S(phi_t, z): a solver whose steps can be differentiated one by one. States of phi
/// are vectors of any layout (e.g. 7 numbers a pose); their gradients are tangents.
class SolverSteps : public virtual Task {
 public:
  struct StepGradient {
    Vector by_phi;  ///< (dS/dphi)^T dnext
    Vector by_z;    ///< (dS/dz)^T dnext
  };
  virtual Vector first_guess() const = 0;  ///< phi_0, the same for every z
  virtual Vector step(const Vector& phi, const Vector& z) const = 0;
  virtual StepGradient pull_back(const Vector& phi, const Vector& z, const Vector& dnext) const = 0;
  /// Makes (phi, z) the point at which everything else is asked; reports as solve() does.
  virtual SolveReport adopt(const Vector& phi, const Vector& z) = 0;
};

}  // namespace imslam::learner
