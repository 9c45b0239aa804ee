#include "pgo/ceres_solve.hpp"
#include "pgo/graph_problem.hpp"
#include "pgo/pose_velocity_graph.hpp"

namespace imslam::pgo {
SolveReport PoseVelocityGraph::solve(const SolverOptions& options) {
  options.validate();
  SolveReport report;
  report.reason = unsolvable_reason(data_);
  if (!report.reason.empty()) return report;

  GraphProblem graph(data_, options_);
  report = solve_with_ceres(graph.problem(), options);
  if (!graph.store(data_)) {
    report.converged = false;
    report.reason = "the solver left a number that is not finite; the states are unchanged";
  }
  return report;
}

double PoseVelocityGraph::cost() const {
  GraphProblem graph(data_, options_);
  double cost = 0.0;
  graph.problem().Evaluate({}, &cost, nullptr, nullptr, nullptr);
  return cost;
}

}  // namespace imslam::pgo
