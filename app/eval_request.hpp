#pragma once

#include <CLI/App.hpp>
#include <string>

#include "slam/base/error.hpp"
#include "slam/evaluation/evaluate.hpp"
#include "slam/evaluation/metric.hpp"

namespace imslam::app {

/// What `imslam eval` is asked for.
struct EvalRequest {
  std::string reference;
  std::string estimate;
  std::string metric;  ///< "ape", "rpe", "kitti" or empty: everything
  evaluation::MetricOptions figure;
  evaluation::EvaluationOptions options;
  std::string T_body_eval;
  std::string vertical = "auto";
  bool json = false;
  std::string csv;
  std::string latex;
  std::string zip;
  bool force = false;
};

/// The two trajectories as read.
struct Paths {
  PosePath reference;
  PosePath estimate;
};

/// Registers all options of `imslam eval`; they write into `request`.
void add_eval_options(CLI::App& eval, EvalRequest& request);

/// Prints and writes the figures that `request` asks for. Exit code 8 where there are none.
/// Throws InputError(kUsage) for outputs that do not go with the metric, InputError(kOutput).
ExitCode report_evaluation(const EvalRequest& request, const Paths& paths);

}  // namespace imslam::app
