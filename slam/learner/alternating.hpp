#pragma once

#include "slam/learner/gradient_strategy.hpp"

namespace imslam::learner {

/// Solver and network in turn, each taking the other as given:  dU/dz = dU/dz|direct.
///
/// What is dropped is (dphi*/dz)^T dU/dphi. Never valid if U depends on z through phi* only: that
/// is noted.
class Alternating : public GradientStrategy {
 public:
  Alternating(Task& task, const Convergence& convergence);

 private:
  void differentiate(const Vector& z, const Random& random, UpperGradient& result) override;

  LowerProblem& problem_;
  const UpperCost& upper_;
  Convergence convergence_;
};

}  // namespace imslam::learner
