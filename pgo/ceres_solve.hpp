#pragma once

#include <ceres/ceres.h>

#include "pgo/options.hpp"
#include "slam/base/solve_report.hpp"

namespace imslam::pgo {

/// The options in the words of Ceres.
ceres::Solver::Options ceres_options(const SolverOptions& options);

/// Runs the solver, silently, and says in our words how it went.
SolveReport solve_with_ceres(ceres::Problem& problem, const SolverOptions& options);

}  // namespace imslam::pgo
