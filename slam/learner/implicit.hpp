#pragma once

#include "slam/learner/gradient_strategy.hpp"

namespace imslam::learner {

/// The implicit function theorem on dL/dphi(phi*(z), z) = 0:
///
///   H q = dU/dphi        dU/dz = dU/dz|direct - (d2L/dz dphi) q        H = d2L/dphi2, undamped
///
/// Direct: the task's factor; without one, H column by column. If the factor is singular,
/// conjugate gradient is tried and noted. A system that stays unsolved gives no gradient.
class Implicit : public GradientStrategy {
 public:
  enum class Method { kDirect, kConjugateGradient, kGradientDescent };

  Implicit(Task& task,
           const Convergence& convergence,
           Method method,
           const LinearOptions& linear = {});

 private:
  void differentiate(const Vector& z, const Random& random, UpperGradient& result) override;
  LinearSolution solve(const Vector& v) const;
  LinearSolution solve_directly(const MatrixProduct& H, const Vector& v) const;

  LowerProblem& problem_;
  const Curvature& curvature_;
  const UpperCost& upper_;
  Convergence convergence_;
  Method method_;
  LinearOptions linear_;
};

}  // namespace imslam::learner
