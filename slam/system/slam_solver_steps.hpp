#pragma once

#include "slam/system/slam_lower_problem.hpp"

namespace imslam::system {

/// The SLAM graph with a solver whose steps can be unrolled, to compare with: Gauss-Newton with the
/// Hessian J^T J = A^-T A^-1 held as it is at the first guess,
///
///   mu_{t+1} = mu_t Exp(d),   d = -A A^T dL/dtau(mu_t),   tau = A y
///
/// Pull-back of a = dU/dtau_{t+1}, with the exact H of mu_t:
///
///   b = A A^T Jr(d)^T a    dU/dz += -(d2L/dz dtau) b    dU/dtau_t = Ad(Exp(-d))^T a - H^T b
///
/// Off the solution H^T b = H b - ad(b)^T dL/dtau: left-invariant fields do not commute. States are
/// GraphPoint::numbers(). The direction of gravity, no group, must be held.
class SlamSolverSteps : public SlamLowerProblem, public learner::SolverSteps {
 public:
  SlamSolverSteps(const pgo::GraphData& data,
                  const pgo::GraphOptions& graph_options,
                  const SlamUpperOptions& upper_options = {});

  Vector first_guess() const override { return first_guess_; }
  Vector step(const Vector& phi, const Vector& z) const override;
  StepGradient pull_back(const Vector& phi, const Vector& z, const Vector& dnext) const override;
  SolveReport adopt(const Vector& phi, const Vector& z) override;

 private:
  void go_to(const Vector& phi, const Vector& z) const;

  Vector first_guess_;
};

}  // namespace imslam::system
