#include "pgo/ceres_solve.hpp"

#include <glog/logging.h>

#include <algorithm>
#include <mutex>
#include <thread>

namespace imslam::pgo {
namespace {

/// Ceres speaks through glog; what it has to say is in the SolveReport.
void silence_ceres() {
  static std::once_flag once;
  std::call_once(once, [] { FLAGS_minloglevel = google::GLOG_FATAL; });
}

SolveReport report_of(const ceres::Solver::Summary& summary) {
  SolveReport report;
  report.converged = summary.termination_type == ceres::CONVERGENCE;
  report.reason = summary.message;
  report.residuals = summary.num_residuals;
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

ceres::Solver::Options ceres_options(const SolverOptions& options) {
  ceres::Solver::Options result;
  result.linear_solver_type = ceres::SPARSE_NORMAL_CHOLESKY;
  result.sparse_linear_algebra_library_type = ceres::SUITE_SPARSE;
  result.max_num_iterations = options.max_iterations;
  result.max_solver_time_in_seconds = 1e12;  // a time limit would make the result depend on load
  result.function_tolerance = options.function_tolerance;
  result.gradient_tolerance = options.gradient_tolerance;
  result.parameter_tolerance = options.parameter_tolerance;
  result.initial_trust_region_radius = options.initial_trust_region;
  result.max_trust_region_radius = 1e16;
  const int cores = std::max(1, static_cast<int>(std::thread::hardware_concurrency()));
  result.num_threads = std::min(options.threads, cores);
  result.logging_type = ceres::SILENT;
  result.minimizer_progress_to_stdout = false;
  return result;
}

SolveReport solve_with_ceres(ceres::Problem& problem, const SolverOptions& options) {
  silence_ceres();
  ceres::Solver::Summary summary;
  ceres::Solve(ceres_options(options), &problem, &summary);
  return report_of(summary);
}

}  // namespace imslam::pgo
