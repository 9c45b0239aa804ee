#pragma once

#include "slam/learner/gradient_strategy.hpp"

namespace imslam::learner {

/// phi*(z) is a formula:  dU/dz = dU/dz|direct + (dphi*/dz)^T dU/dphi.
class ClosedFormGradient : public GradientStrategy {
 public:
  ClosedFormGradient(Task& task, const Convergence& convergence);

 private:
  void differentiate(const Vector& z, const Random& random, UpperGradient& result) override;

  LowerProblem& problem_;
  const ClosedForm& form_;
  const UpperCost& upper_;
  Convergence convergence_;
};

}  // namespace imslam::learner
