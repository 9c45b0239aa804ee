#pragma once

#include <string>

namespace imslam {

/// What an iterative solver says about its result. The result itself is always finite: a solver
/// that fails leaves the best point it has seen.
struct SolveReport {
  bool converged = false;      ///< a tolerance was met; false: see `reason`
  int iterations = 0;          ///< accepted and rejected steps
  int residuals = 0;           ///< scalar ones
  double initial_cost = 0.0;   ///< before the first step
  double cost = 0.0;           ///< at the returned point
  double gradient_norm = 0.0;  ///< largest entry of the gradient there: 0 at a stationary point
  double ms_per_iteration = 0.0;
  std::string reason;  ///< why it stopped, for people
};

}  // namespace imslam
