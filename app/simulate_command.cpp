#include <fmt/format.h>

#include <cstdio>
#include <memory>
#include <string>
#include <vector>

#include "app/command.hpp"
#include "datasets/simulation/simulate.hpp"
#include "slam/base/config.hpp"
#include "slam/base/progress.hpp"

namespace imslam::app {
namespace {

constexpr const char* kSimulateExamples =
    "Examples:\n"
    "  imslam simulate out/room                             the built-in default sequence\n"
    "  imslam simulate out/street --set scene=street --set duration_s=60 --set seed=3\n"
    "  imslam simulate out/bad_imu --set imu.grade=phone\n"
    "  imslam simulate out/again -c out/street/simulation.yaml\n"
    "`imslam simulate --list` prints every key with its default and meaning.";

struct SimulateArguments {
  std::string out;
  std::vector<std::string> files;
  std::vector<std::string> assignments;
  bool list = false;
};

ExitCode simulate(const SimulateArguments& arguments, bool quiet) {
  auto options = simulation::default_sequence_options();
  Config config;
  config.section("simulation", options);
  config.listed_by("imslam simulate --list");
  for (const std::string& file : arguments.files) config.load_file(file);
  for (const std::string& assignment : arguments.assignments)
    config.set("simulation." + assignment, "--set");
  if (arguments.list) {
    std::fputs(config.to_yaml(true).c_str(), stdout);
    return ExitCode::kOk;
  }
  if (arguments.out.empty())
    throw InputError("simulate: name the folder to write", ExitCode::kUsage);
  options.validate();
  ProgressBar bar("simulate", !quiet);
  const auto summary =
      simulation::simulate(options, arguments.out,
                           [&](std::size_t done, std::size_t total) { bar.update(done, total); });
  bar.clear();
  fmt::print(
      "{}: {} stereo pairs, {} IMU samples, {:.1f} m, {} textures; {:.0f} ms to render and "
      "{:.0f} ms to write a pair\n",
      arguments.out, summary.frames, summary.imu_samples, summary.distance_m, summary.textures,
      1e3 * summary.render_s, 1e3 * summary.write_s);
  return ExitCode::kOk;
}

}  // namespace

void add_simulate_command(CLI::App& app, Action& action, const CommonOptions& common) {
  auto* command = app.add_subcommand("simulate", "Render a stereo-inertial sequence with truth");
  command->footer(kSimulateExamples);
  auto arguments = std::make_shared<SimulateArguments>();
  command->add_option("out", arguments->out, "Folder to write (EuRoC layout)");
  command->add_option("-c,--config", arguments->files, "YAML file(s) with simulation keys");
  command->add_option("--set", arguments->assignments, "Override one key")->type_name("KEY=VALUE");
  command->add_flag("--list", arguments->list, "Print all keys and stop");
  command->callback([&action, arguments, &common] {
    action = [arguments, &common] { return simulate(*arguments, common.quiet); };
  });
}

}  // namespace imslam::app
