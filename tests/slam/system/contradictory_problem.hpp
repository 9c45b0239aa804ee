#pragma once

#include <gtest/gtest.h>

#include <string>

#include "slam/learner/make_strategy.hpp"
#include "slam/system/slam_lower_problem.hpp"
#include "tests/slam/system/contradictory_graph.hpp"

namespace imslam::system::testing {

inline constexpr int kStates = 12;

inline learner::StrategyOptions named(const std::string& name) {
  learner::StrategyOptions options;
  options.strategy = name;
  options.tolerance = 1e-9;
  options.linear_tolerance = 1e-7;  // products are central differences themselves
  return options;
}

inline SlamUpperOptions as_published() {
  SlamUpperOptions options;
  options.kind = UpperKind::kPublished;
  options.published_weight = 4.0;
  return options;
}

inline SlamLowerProblem problem_of(const pgo::PoseVelocityGraph& graph,
                                   const SlamUpperOptions& upper = {}) {
  pgo::SolverOptions solver;
  solver.threads = 1;
  return SlamLowerProblem(graph.data(), graph.options(), solver, upper);
}

inline learner::UpperGradient gradient_by(const std::string& strategy,
                                          SlamLowerProblem& task,
                                          const learner::Vector& z) {
  const learner::UpperGradient upper = (*make_strategy(named(strategy), task))(z, Random(0));
  EXPECT_TRUE(upper.usable()) << strategy << ": " << name_of(upper.refusal) << " "
                              << upper.solve.reason << " " << upper.note;
  expects(upper.usable(), "a gradient to go on with");
  return upper;
}

}  // namespace imslam::system::testing
