#pragma once

#include "slam/learner/gradient_strategy.hpp"

namespace imslam::learner {

/// The envelope theorem: with U = L and dL/dphi = 0 the way through the solver vanishes,
///
///   dU/dz = dL/dz + (dphi*/dz)^T dL/dphi = dL/dz at phi*
///
/// No unrolling, no second derivative. The error is first order in what is left of dL/dphi.
class OneStep : public GradientStrategy {
 public:
  OneStep(Task& task, const Convergence& convergence);

 private:
  void differentiate(const Vector& z, const Random& random, UpperGradient& result) override;

  LowerProblem& problem_;
  const StationaryCost& cost_;
  Convergence convergence_;
};

}  // namespace imslam::learner
