#pragma once

#include <vector>

#include "slam/learner/gradient_strategy.hpp"
#include "slam/learner/sampled_problem.hpp"

namespace imslam::learner {

/// REINFORCE with what a surrogate s explains taken out and put back without noise:
///
///   g = (L(x) - s(x)) d log p(x|z)/dz + s'      E[s'] = d/dz E[s(x)],   hence   E[g] = dU/dz
///
/// E[g] does not depend on the surrogate's gamma, so the variance falls with V = E |g|^2:
///
///   dV/dgamma = 2 E[ -(g^T score) ds/dgamma + (ds'/dgamma)^T g ]
///
/// With the baseline of log_derivative.hpp on top, the mean of L - s over the other draws is taken
/// off each L - s too: unbiased still, and what all draws of one z share need not be learned.
///
/// Several tasks may share a surrogate: it is only read here. Between the steps, in order:
///   for (auto& strategy : strategies) strategy.teach(surrogate);   surrogate.step();
class ControlVariate : public GradientStrategy {
 public:
  struct Options {
    int samples = 16;       ///< draws per gradient
    bool baseline = false;  ///< of the other draws: needs two
  };
  ControlVariate(Task& task, const Surrogate& surrogate, const Options& options);

  /// Hands dV/dgamma of the last gradient's draws to the surrogate.
  void teach(Surrogate& surrogate) const;

 private:
  struct Draw {
    Vector x;
    double cost = 0.0;
    double rest = 0.0;  ///< L - s
    Vector score;
    Vector gradient;  ///< g
  };
  bool has_baseline() const { return options_.baseline && draws_.size() > 1; }
  void differentiate(const Vector& z, const Random& random, UpperGradient& result) override;

  const SampledProblem& problem_;
  const Surrogate& surrogate_;
  Options options_;
  Vector z_;
  std::vector<Draw> draws_;
};

}  // namespace imslam::learner
