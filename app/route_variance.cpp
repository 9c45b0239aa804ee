#include <fmt/format.h>

#include <CLI/Config.hpp>
#include <CLI/Formatter.hpp>
#include <filesystem>
#include <memory>

#include "app/route_command.hpp"
#include "slam/base/file.hpp"
#include "slam/base/progress.hpp"
#include "slam/plugins/routing/variance_study.hpp"

namespace imslam::app {
namespace {

constexpr const char* kRouteVarianceExamples =
    "Trains by the control variate and looks, every --every steps, at the gradient that each\n"
    "estimator would take there: the variance over 16 mini-batches of 32 instances, summed over "
    "all\n"
    "weights. All estimators see the same instances and draw as often.\n"
    "\n"
    "Example:\n"
    "  imslam route variance --agents 10 --cities 50 --steps 200 --out runs/variance";

struct VarianceArguments {
  routing::VarianceStudyOptions options;
  std::string out;
};

ExitCode study(const VarianceArguments& arguments, bool quiet) {
  ProgressBar bar("variance", !quiet);
  const auto rows = routing::variance_study(arguments.options, [&](int done, int steps) {
    bar.update(static_cast<std::size_t>(done), static_cast<std::size_t>(steps));
  });
  bar.clear();
  fmt::print("{}", routing::variance_csv(rows));
  if (arguments.out.empty()) return ExitCode::kOk;
  std::error_code error;
  const std::filesystem::path folder = arguments.out;
  std::filesystem::create_directories(folder, error);
  write_file_atomic(folder / "variance.csv", routing::variance_csv(rows));
  write_file_atomic(folder / "variance.svg", routing::variance_svg(arguments.options, rows));
  return ExitCode::kOk;
}

}  // namespace

void add_route_variance(CLI::App& parent, Action& action, const CommonOptions& common) {
  auto* command = parent.add_subcommand("variance", "Compare the gradients' variance in training");
  command->footer(kRouteVarianceExamples);
  auto arguments = std::make_shared<VarianceArguments>();
  command->add_option("--agents", arguments->options.agents, "Agents")->capture_default_str();
  command->add_option("--cities", arguments->options.cities, "Cities")->capture_default_str();
  command->add_option("--samples", arguments->options.samples, "Draws per instance, 2 or more")
      ->capture_default_str();
  command->add_option("--steps", arguments->options.steps, "Of the training")
      ->capture_default_str();
  command->add_option("--every", arguments->options.every, "Steps between looks")
      ->capture_default_str();
  command
      ->add_option("--surrogate-rate", arguments->options.surrogate_rate,
                   "Learning rate of the surrogate")
      ->capture_default_str();
  command->add_option("--out", arguments->out, "Folder for variance.csv and variance.svg");
  command->callback([&action, arguments, &common] {
    action = [arguments, &common] { return study(*arguments, common.quiet); };
  });
}

}  // namespace imslam::app
