#pragma once

#include "slam/learner/gradient_strategy.hpp"

namespace imslam::learner {

/// Reverse through the solver's own steps phi_{t+1} = S(phi_t, z), t = 0 ... T - 1:
///
///   a_T = dU/dphi    dU/dz = dU/dz|direct + sum_t (dS/dz)^T a_{t+1}    a_t = (dS/dphi)^T a_{t+1}
///
/// Exact for the phi_T that T steps reach, converged or not; towards the implicit gradient as T
/// grows. Memory grows with the steps that are kept: with `last` > 0 only the last ones are kept
/// and the sum is cut there (biased, by less the faster the solver contracts).
class Unrolled : public GradientStrategy {
 public:
  struct Options {
    int steps = 20;  ///< T
    int last = 0;    ///< steps to go back; 0: all
    /// Convergence asked of phi_T; 0: none, since the gradient is that of phi_T anyway.
    double tolerance = 0.0;
  };
  Unrolled(Task& task, const Options& options);

 private:
  void differentiate(const Vector& z, const Random& random, UpperGradient& result) override;

  SolverSteps& solver_;
  const UpperCost& upper_;
  Options options_;
};

}  // namespace imslam::learner
