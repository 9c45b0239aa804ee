#include "slam/learner/make_strategy.hpp"

#include "slam/learner/alternating.hpp"
#include "slam/learner/closed_form.hpp"
#include "slam/learner/constrained.hpp"
#include "slam/learner/control_variate.hpp"
#include "slam/learner/implicit.hpp"
#include "slam/learner/log_derivative.hpp"
#include "slam/learner/one_step.hpp"
#include "slam/learner/reparameterised.hpp"
#include "slam/learner/unrolled.hpp"

namespace imslam::learner {

std::unique_ptr<GradientStrategy> make_strategy(const StrategyOptions& options,
                                                Task& task,
                                                const Surrogate* surrogate) {
  const std::string& name = options.strategy;
  const Convergence convergence{options.tolerance};
  const LinearOptions linear{options.linear_tolerance, options.linear_iterations,
                             options.linear_step};
  const auto implicit = [&](Implicit::Method method) {
    return std::make_unique<Implicit>(task, convergence, method, linear);
  };
  if (name == "closed_form") return std::make_unique<ClosedFormGradient>(task, convergence);
  if (name == "one_step") return std::make_unique<OneStep>(task, convergence);
  if (name == "alternating") return std::make_unique<Alternating>(task, convergence);
  if (name == "implicit_direct") return implicit(Implicit::Method::kDirect);
  if (name == "implicit_conjugate_gradient") return implicit(Implicit::Method::kConjugateGradient);
  if (name == "implicit_gradient_descent") return implicit(Implicit::Method::kGradientDescent);
  if (name == "unrolled" || name == "unrolled_truncated") {
    const int last = name == "unrolled" ? 0 : options.last;
    return std::make_unique<Unrolled>(task, Unrolled::Options{options.steps, last, 0.0});
  }
  if (name == "constrained") {
    Constrained::Options constrained;
    constrained.hold_kinks = options.hold_kinks;
    constrained.linear_tolerance = options.linear_tolerance;
    return std::make_unique<Constrained>(task, convergence, constrained);
  }
  if (name == "log_derivative") {
    return std::make_unique<LogDerivative>(
        task, LogDerivative::Options{options.samples, options.baseline});
  }
  if (name == "reparameterised") {
    return std::make_unique<Reparameterised>(task, Reparameterised::Options{options.samples});
  }
  if (name == "control_variate") {
    expects(surrogate != nullptr, "make_strategy: control_variate needs a surrogate");
    return std::make_unique<ControlVariate>(task, *surrogate,
                                            ControlVariate::Options{options.samples});
  }
  throw InputError("learner.strategy: there is no " + name, ExitCode::kUsage);
}

}  // namespace imslam::learner
