#include <fmt/format.h>

#include <CLI/Config.hpp>
#include <CLI/Formatter.hpp>
#include <filesystem>
#include <map>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "app/command.hpp"
#include "app/imu_table.hpp"
#include "imu_net/imu_corrector.hpp"
#include "imu_net/imu_weights.hpp"
#include "slam/base/file.hpp"
#include "slam/base/text.hpp"
#include "slam/training/graph_bias.hpp"
#include "slam/training/inertial_log_file.hpp"
#include "slam/training/inertial_methods.hpp"

namespace imslam::app {
namespace {

namespace fs = std::filesystem;

constexpr const char* kImuExamples =
    "A log is a EuRoC folder, or PATH/NAME of NAME_imu.csv with NAME_truth.tum (TUM) or\n"
    "NAME_poses.txt (KITTI, with T_cam0_imu.txt). Each window starts from its true state; nothing\n"
    "corrects it on the way. Rows:\n"
    "  raw         the readings as they are, the datasheet's noise\n"
    "  rest bias   minus the mean rate of the first second at rest: what an IMU can know alone\n"
    "  graph bias  minus the bias at the window's start of a graph over the whole log with the\n"
    "              truth as vision: it sees the future\n"
    "  network     corrected by the shipped network, and by those of --weights\n"
    "NEES / dof is 1 where the covariance tells the truth; -log p judges error and covariance\n"
    "together. Exit codes: 2 usage, 3 data, 4 calibration, 5 weights, 6 output, 8 no log is long\n"
    "enough for a window.\n"
    "\n"
    "Examples:\n"
    "  imslam imu MH_01_easy V1_02_medium --out runs/imu\n"
    "  imslam imu kitti_imu/05 kitti_imu/08 --extrinsics T_cam0_imu.txt --windows 1,10";

struct ImuArguments {
  std::vector<std::string> logs;
  std::string windows = "1,5,10";
  double stride_s = 0.0;
  std::vector<std::string> weights;
  std::string extrinsics;
  std::string out;
  bool force = false;
};

/// The row of a trained network; `file` empty: the shipped one.
training::InertialMethod network_method(const std::string& name, const std::string& file) {
  const auto network = imu::load_imu_network(file).network;
  return training::corrected_method(name, [network](const training::InertialLog& log) {
    return imu::correct_samples(network, log.samples, log.noise);
  });
}

std::vector<training::InertialMethod> methods_of(const ImuArguments& arguments) {
  std::vector<training::InertialMethod> methods = {
      training::raw_method(), training::rest_bias_method(), training::graph_bias_method()};
  if (imu::shipped_imu_weights()) methods.push_back(network_method("network", ""));
  for (const std::string& file : arguments.weights) {
    methods.push_back(network_method(fs::path(file).stem().string(), file));
  }
  return methods;
}

std::vector<training::OpenIntegrationOptions> windows_of(const ImuArguments& arguments) {
  std::vector<training::OpenIntegrationOptions> windows;
  for (const std::string_view word : split(arguments.windows, ',')) {
    const auto seconds = parse_double(word);
    if (!seconds) {
      throw InputError(fmt::format("--windows {}: expected seconds with commas between, as in "
                                   "1,5,10; '{}' is no number",
                                   arguments.windows, word),
                       ExitCode::kUsage);
    }
    training::OpenIntegrationOptions options;
    options.window_s = *seconds;
    options.stride_s = arguments.stride_s;
    options.validate();
    windows.push_back(options);
  }
  return windows;
}

/// Runs all methods on all logs and collects the tables, the pooled one last.
class ImuComparison {
 public:
  explicit ImuComparison(const ImuArguments& arguments)
      : methods_(methods_of(arguments)), windows_(windows_of(arguments)) {
    options_.T_cam0_imu = arguments.extrinsics;
  }

  ImuTable add(const std::string& path) {
    const training::InertialLogReading reading = training::read_inertial_log(path, options_);
    ImuTable table;
    table.title = reading.log.name;
    table.remarks = describe(reading);
    std::vector<training::InertialMethod::Result> results;
    for (const auto& method : methods_) {
      results.push_back(method.correct(reading.log));
      if (results.back().remark.empty()) continue;
      table.remarks.push_back(method.name + ": " + results.back().remark);
    }
    for (std::size_t w = 0; w < windows_.size(); ++w) {
      for (std::size_t m = 0; m < methods_.size(); ++m) {
        const auto result =
            training::integrate_open(reading.log, results[m].correction, windows_[w]);
        table.rows.push_back({methods_[m].name, windows_[w].window_s, training::score(result)});
        training::OpenIntegration& pool = pools_[{w, m}];
        pool.degraded += result.degraded;
        pool.windows.insert(pool.windows.end(), result.windows.begin(), result.windows.end());
      }
    }
    return table;
  }

  ImuTable pooled() const {
    ImuTable table;
    table.title = "all logs";
    for (const auto& [place, pool] : pools_) {
      table.rows.push_back(
          {methods_[place.second].name, windows_[place.first].window_s, training::score(pool)});
    }
    return table;
  }

 private:
  training::InertialLogFileOptions options_;
  std::vector<training::InertialMethod> methods_;
  std::vector<training::OpenIntegrationOptions> windows_;
  std::map<std::pair<std::size_t, std::size_t>, training::OpenIntegration> pools_;
};

/// Before the work, so that it is not lost.
void prepare_folder(const ImuArguments& arguments) {
  if (arguments.out.empty()) return;
  std::error_code error;
  fs::create_directories(arguments.out, error);
  if (error) {
    throw InputError(arguments.out + ": cannot be made (" + error.message() + ")",
                     ExitCode::kOutput);
  }
  for (const char* name : {"imu.csv", "imu.json"}) {
    const fs::path file = fs::path(arguments.out) / name;
    if (arguments.force || !fs::exists(file)) continue;
    throw InputError(file.string() + ": exists already; choose another folder or give --force",
                     ExitCode::kOutput);
  }
}

ExitCode compare(const ImuArguments& arguments) {
  ImuComparison comparison(arguments);
  prepare_folder(arguments);
  std::vector<ImuTable> tables;
  for (const std::string& path : arguments.logs) {
    tables.push_back(comparison.add(path));
    fmt::print("{}\n", as_text(tables.back()));
  }
  const ImuTable pooled = comparison.pooled();
  if (arguments.logs.size() > 1) {
    tables.push_back(pooled);
    fmt::print("{}", as_text(pooled));
  }
  if (!arguments.out.empty()) {
    write_file_atomic(fs::path(arguments.out) / "imu.csv", as_csv(tables));
    write_file_atomic(fs::path(arguments.out) / "imu.json", as_json(tables));
  }
  for (const ImuRow& row : pooled.rows) {
    if (row.score.windows > 0) return ExitCode::kOk;
  }
  throw InputError("no log has a window of " + arguments.windows +
                       " s without gaps; give shorter --windows or longer logs",
                   ExitCode::kEvaluation);
}

}  // namespace

void add_imu_command(CLI::App& app, Action& action) {
  auto* command = app.add_subcommand("imu", "Integrate inertial logs openly, compare with truth");
  command->footer(kImuExamples);
  auto arguments = std::make_shared<ImuArguments>();
  command->add_option("logs", arguments->logs, "EuRoC folders, or PATH/NAME")->required();
  command->add_option("--windows", arguments->windows, "Lengths of the windows [s]")
      ->capture_default_str();
  command->add_option("--stride", arguments->stride_s,
                      "Seconds between the starts of windows (their length)");
  command->add_option("--weights", arguments->weights, "Trained network(s), a row each")
      ->type_name("FILE");
  command->add_option("--extrinsics", arguments->extrinsics,
                      "T_cam0_imu.txt for KITTI's poses, if it is not beside them");
  command->add_option("--out", arguments->out, "Folder for imu.csv and imu.json");
  command->add_flag("--force", arguments->force, "Overwrite files");
  command->callback([&action, arguments] { action = [arguments] { return compare(*arguments); }; });
}

}  // namespace imslam::app
