#pragma once

#include <memory>

#include "slam/learner/gradient_strategy.hpp"
#include "slam/learner/sampled_problem.hpp"
#include "slam/learner/strategy_options.hpp"

namespace imslam::learner {

/// The strategy of options.strategy for `task`, which must outlive it, as must the surrogate that
/// control_variate asks for. Throws InputError(kUsage) on an unknown name, ContractError naming the
/// interface that the task lacks.
std::unique_ptr<GradientStrategy> make_strategy(const StrategyOptions& options,
                                                Task& task,
                                                const Surrogate* surrogate = nullptr);

}  // namespace imslam::learner
