#include "slam/learner/strategy_options.hpp"

#include "slam/learner/bounds.hpp"

namespace imslam::learner {

const std::vector<std::string>& strategy_names() {
  static const std::vector<std::string> names = {"closed_form",
                                                 "one_step",
                                                 "implicit_direct",
                                                 "implicit_conjugate_gradient",
                                                 "implicit_gradient_descent",
                                                 "unrolled",
                                                 "unrolled_truncated",
                                                 "constrained",
                                                 "alternating",
                                                 "log_derivative",
                                                 "reparameterised",
                                                 "control_variate"};
  return names;
}

void StrategyOptions::describe(Config& config) {
  config.field("strategy", strategy, strategy_names(), "the gradient's way through the solver");
  config.field("tolerance", tolerance, "largest dL/dphi of a solve that gives a gradient");
  config.field("linear_tolerance", linear_tolerance,
               "relative residual of implicit and constrained systems");
  config.field("linear_iterations", linear_iterations, "at most, for these systems");
  config.field("linear_step", linear_step, "of implicit_gradient_descent; 0: found by itself");
  config.field("steps", steps, "of the solver, unrolled");
  config.field("last", last, "steps that unrolled_truncated goes back");
  config.field("hold_kinks", hold_kinks, "constrained: a kink counts as active");
  config.field("samples", samples, "draws per gradient, where the cost is an expectation");
  config.field("baseline", baseline, "log_derivative: less the mean cost of the other draws");
}

void StrategyOptions::validate() const {
  require_within("learner.tolerance", tolerance, 0.0, 1e12);
  require_within("learner.linear_tolerance", linear_tolerance, 0.0, 1e12);
  require_within("learner.linear_iterations", linear_iterations, 1, 1e9);
  require_within("learner.linear_step", linear_step, 0.0, 1e12);
  require_within("learner.steps", steps, 1, 1e9);
  require_within("learner.last", last, 1, 1e9);
  require_within("learner.samples", samples, 1, 1e9);
}

}  // namespace imslam::learner
