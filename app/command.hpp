#pragma once

#include <CLI/App.hpp>
#include <functional>
#include <string>
#include <vector>

#include "slam/base/error.hpp"

namespace imslam::app {

/// What the parsed command line asks for. Each subcommand sets it when it is the one chosen.
using Action = std::function<ExitCode()>;

/// Options that every subcommand has.
struct CommonOptions {
  bool quiet = false;
  bool verbose = false;
  std::string log_file;
  int threads = 0;                        ///< 0: all cores
  std::vector<std::string> command_line;  ///< as typed, for the manifest
};

// One file per subcommand: registers its options and, when chosen, sets `action`.
void add_run_command(CLI::App& app, Action& action, const CommonOptions& common);
void add_bench_command(CLI::App& app, Action& action, const CommonOptions& common);
void add_eval_command(CLI::App& app, Action& action);
void add_check_command(CLI::App& app, Action& action);
void add_simulate_command(CLI::App& app, Action& action, const CommonOptions& common);
void add_report_command(CLI::App& app, Action& action);
void add_config_command(CLI::App& app, Action& action);
void add_finetune_command(CLI::App& app, Action& action, const CommonOptions& common);
void add_imu_command(CLI::App& app, Action& action);
void add_model_command(CLI::App& app, Action& action);
void add_route_command(CLI::App& app, Action& action, const CommonOptions& common);
void add_train_command(CLI::App& app, Action& action, const CommonOptions& common);

}  // namespace imslam::app
