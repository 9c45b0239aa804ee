#pragma once

#include "slam/learner/gradient_strategy.hpp"
#include "slam/learner/sampled_problem.hpp"

namespace imslam::learner {

/// dU/dz = E[ (dT/dz)^T dL/dx ] with x = T(z, noise): little variance; as unbiased as T is true to
/// p(x|z) (a relaxation of a discrete x is not).
class Reparameterised : public GradientStrategy {
 public:
  struct Options {
    int samples = 16;  ///< draws per gradient
  };
  Reparameterised(Task& task, const Options& options);

 private:
  void differentiate(const Vector& z, const Random& random, UpperGradient& result) override;

  const ReparameterisedProblem& problem_;
  Options options_;
};

}  // namespace imslam::learner
