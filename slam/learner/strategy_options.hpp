#pragma once

#include <string>
#include <vector>

#include "slam/base/config.hpp"

namespace imslam::learner {

/// Which way the gradient takes through the solver, and how exactly.
struct StrategyOptions {
  std::string strategy = "one_step";  ///< one of strategy_names()
  double tolerance = 1e-6;            ///< largest dL/dphi of an accepted solve, in units of L
  double linear_tolerance = 1e-10;    ///< relative residual of implicit and constrained systems
  int linear_iterations = 1000;       ///< at most, of implicit_conjugate_gradient and _descent
  double linear_step = 0.0;           ///< of implicit_gradient_descent; 0: found by itself
  int steps = 20;                     ///< of the solver, unrolled
  int last = 5;                       ///< steps that unrolled_truncated goes back
  bool hold_kinks = false;            ///< constrained: which side of a kink
  int samples = 16;                   ///< draws per gradient, where U is an expectation
  bool baseline = true;               ///< log_derivative: less the other draws' mean cost

  void describe(Config& config);
  void validate() const;  ///< Throws InputError(kUsage) naming key, value and bound.
};

const std::vector<std::string>& strategy_names();

}  // namespace imslam::learner
