#include <CLI/Config.hpp>
#include <CLI/Formatter.hpp>
#include <cstdio>
#include <exception>
#include <filesystem>
#include <new>

#include "app/command.hpp"
#include "app/interrupt.hpp"
#include "app/usage_error.hpp"
#include "app/version.hpp"
#include "slam/base/log.hpp"
#include "slam/base/parallel.hpp"

namespace imslam::app {
namespace {

constexpr const char* kDescription =
    "imslam: stereo-inertial SLAM that runs on a EuRoC, TUM-VI, KITTI or plain folder and\n"
    "reports honestly. Every result lands in runs/<time>_<dataset>/ (runs/latest).";

constexpr const char* kFooter =
    "Examples:\n"
    "  imslam run                               the built-in simulated sequence\n"
    "  imslam run MH_01_easy                    a EuRoC folder (format found by itself)\n"
    "  imslam run sequences/00 --frames 0:500 --set pgo.huber=1.0\n"
    "  imslam eval truth.tum runs/latest/trajectory.tum\n"
    "  imslam check my_recording --json\n"
    "  imslam route solve --random 500 --agents 10 --out runs/route\n"
    "\n"
    "Exit codes: 0 ok, 1 internal error, 2 usage or configuration, 3 input data, 4 calibration,\n"
    "  5 model file, 6 output, 7 tracking lost (partial results written), 8 evaluation "
    "impossible,\n"
    "  9 resource limit, 10 check --strict: warnings, 128 + number of the signal that stopped it\n"
    "  (130 Ctrl-C, 143 SIGTERM, 129 SIGHUP): what a run had seen so far is written";

void add_common_options(CLI::App& app, CommonOptions& common) {
  app.add_flag("-q,--quiet", common.quiet, "Only errors on stderr");
  app.add_flag("-v,--verbose", common.verbose, "Debug messages on stderr");
  app.add_option("--log-file", common.log_file, "Also write all messages to this file");
  app.add_option("--threads", common.threads,
                 "Threads, 0 = all cores (results do not depend on it)")
      ->check(CLI::Range(0, 1024));
}

void start_services(const CommonOptions& common) {
  const auto level = common.quiet     ? log::Level::kQuiet
                     : common.verbose ? log::Level::kVerbose
                                      : log::Level::kNormal;
  log::start(level);
  if (!common.log_file.empty()) log::add_file(common.log_file);
  set_thread_count(common.threads);
}

/// What the shell gets to see: a stop names the signal that asked for it.
int shell_code(ExitCode code) {
  const bool stopped = code == ExitCode::kInterrupted && interrupted();
  return stopped ? interrupt_exit_code() : static_cast<int>(code);
}

int report_failure(const char* what, ExitCode code) {
  log::error("{}", what);
  return shell_code(code);
}

int execute(int argc, char** argv) {
  CLI::App app(kDescription, "imslam");
  app.footer(kFooter);
  app.set_version_flag("--version", version_text());
  app.require_subcommand(1);
  app.fallthrough();
  app.failure_message(usage_error);

  CommonOptions common;
  common.command_line.assign(argv, argv + argc);
  Action action;
  add_common_options(app, common);
  add_run_command(app, action, common);
  add_bench_command(app, action, common);
  add_eval_command(app, action);
  add_check_command(app, action);
  add_simulate_command(app, action, common);
  add_report_command(app, action);
  add_config_command(app, action);
  add_finetune_command(app, action, common);
  add_imu_command(app, action);
  add_model_command(app, action);
  add_train_command(app, action, common);
  add_route_command(app, action, common);

  try {
    app.parse(argc, argv);
  } catch (const CLI::ParseError& error) {
    const int shown = app.exit(error);
    return shown == 0 ? 0 : static_cast<int>(ExitCode::kUsage);
  }
  start_services(common);
  return shell_code(action());
}

}  // namespace
}  // namespace imslam::app

int main(int argc, char** argv) {
  using imslam::ExitCode;
  using imslam::app::report_failure;
  imslam::app::catch_interrupts();
  try {
    return imslam::app::execute(argc, argv);
  } catch (const imslam::InputError& error) {
    return report_failure(error.what(), error.code());
  } catch (const std::filesystem::filesystem_error& error) {
    // Links in a circle, names too long, folders without permission.
    return report_failure(error.what(), ExitCode::kData);
  } catch (const std::bad_alloc&) {
    return report_failure("out of memory; use a shorter sequence (--frames) or more memory",
                          ExitCode::kResource);
  } catch (const std::exception& error) {
    return report_failure(error.what(), ExitCode::kInternal);
  }
}
