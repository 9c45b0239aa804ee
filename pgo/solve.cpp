#include <cmath>

#include "pgo/graph_problem.hpp"
#include "pgo/pose_velocity_graph.hpp"

namespace imslam::pgo {
namespace {

SolveReport report_of(const ceres::Solver::Summary& summary) {
  SolveReport report;
  report.converged = summary.termination_type == ceres::CONVERGENCE;
  report.reason = summary.message;
  report.initial_cost = summary.initial_cost;
  report.cost = summary.final_cost;
  if (summary.iterations.empty()) return report;
  report.iterations = static_cast<int>(summary.iterations.size()) - 1;
  report.gradient_norm = summary.iterations.back().gradient_max_norm;
  if (report.iterations > 0) {
    double total_s = 0.0;
    for (std::size_t i = 1; i < summary.iterations.size(); ++i) {
      total_s += summary.iterations[i].iteration_time_in_seconds;
    }
    report.ms_per_iteration = 1e3 * total_s / report.iterations;
  }
  return report;
}

}  // namespace

SolveReport PoseVelocityGraph::solve(const SolverOptions& options) {
  options.validate();
  SolveReport report;
  report.reason = unsolvable_reason(data_);
  if (!report.reason.empty()) return report;

  GraphProblem graph(data_, options_);
  ceres::Solver::Summary summary;
  ceres::Solve(ceres_options(options), &graph.problem(), &summary);
  report = report_of(summary);
  if (!summary.IsSolutionUsable()) return report;
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
