#pragma once

#include "slam/learner/gradient_strategy.hpp"
#include "slam/learner/sampled_problem.hpp"

namespace imslam::learner {

/// REINFORCE (Williams 1992): the solver is a black box, x may be discrete.
///
///   dU/dz = E[ (L(x) - b) d log p(x|z)/dz ]
///
/// Unbiased, with much variance. The baseline b of a draw is the mean cost of the other draws, on
/// which it does not depend, so it biases nothing (Kool, van Hoof, Welling 2019); or a constant.
class LogDerivative : public GradientStrategy {
 public:
  struct Options {
    int samples = 16;       ///< draws per gradient
    bool baseline = true;   ///< of the other draws: needs two
    double constant = 0.0;  ///< baseline without others
  };
  LogDerivative(Task& task, const Options& options);

 private:
  void differentiate(const Vector& z, const Random& random, UpperGradient& result) override;

  const SampledProblem& problem_;
  Options options_;
};

}  // namespace imslam::learner
