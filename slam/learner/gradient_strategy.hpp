#pragma once

#include <string>
#include <string_view>

#include "slam/base/error.hpp"
#include "slam/base/random.hpp"
#include "slam/learner/linear_solve.hpp"
#include "slam/learner/lower_problem.hpp"

namespace imslam::learner {

/// Why there is no gradient.
enum class Refusal {
  kNone,
  kUnconverged,  ///< the lower solve: its gradients would be tens of percent wrong
  kLinearSolve,  ///< the system of the implicit derivative could not be solved
  kMultipliers,  ///< an active inequality pulls instead of pushing: no solution
  kNotFinite,
};
inline constexpr int kRefusalCount = 5;

std::string_view name_of(Refusal refusal);  ///< "unconverged solve"

/// dU/dz in total, through the solver, and how it came about.
struct UpperGradient {
  double cost = 0.0;         ///< U
  Vector gradient;           ///< dU/dz; empty if refused
  SolveReport solve;         ///< of the lower level
  double residual = 0.0;     ///< largest entry of dL/dphi after the solve
  LinearSolveReport linear;  ///< of the implicit derivative, where there is one
  int samples = 0;           ///< drawn and solved, where U is an expectation
  int kinks = 0;             ///< active inequalities without force: the gradient is one-sided
  double variance = 0.0;     ///< of one sample's gradient, summed over z, where U is an expectation
  Refusal refusal = Refusal::kNone;
  std::string note;  ///< fallbacks taken, for people

  bool usable() const { return refusal == Refusal::kNone; }
};

/// One way for the gradient to go through the solver. Holds on to the task, which must outlive it.
class GradientStrategy {
 public:
  virtual ~GradientStrategy() = default;

  /// Solves the lower level for z and differentiates. `random` is the stream of this sample; only
  /// strategies that draw use it, and they fork it, so that threads change nothing.
  UpperGradient operator()(const Vector& z, const Random& random);

 protected:
  /// Fills cost, gradient and reports, or sets `refusal`.
  virtual void differentiate(const Vector& z, const Random& random, UpperGradient& result) = 0;
};

/// When a lower solve is good enough.
struct Convergence {
  double tolerance = 1e-6;  ///< largest entry of dL/dphi, in units of the cost

  /// Notes the report in `result`; false, with the refusal, if the solve is not good enough.
  /// `stationarity` is dL/dphi where the task offers it: then its word counts, not the solver's.
  bool accepts(const SolveReport& report, const Task& task, UpperGradient& result) const;
};

/// The interface of a task that a strategy cannot do without. ContractError names both.
template <typename Interface>
Interface& required(Task& task, const char* strategy, const char* interface) {
  auto* const found = dynamic_cast<Interface*>(&task);
  if (found == nullptr) {
    throw ContractError(std::string("the strategy ") + strategy + " needs a task that is a " +
                        interface);
  }
  return *found;
}

}  // namespace imslam::learner
