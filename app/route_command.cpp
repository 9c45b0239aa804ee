#include <fmt/format.h>

#include <CLI/Config.hpp>
#include <CLI/Formatter.hpp>
#include <memory>
#include <string>

#include "app/route_command.hpp"
#include "app/training_command.hpp"
#include "slam/base/text.hpp"
#include "slam/plugins/routing/routing_training.hpp"

namespace imslam::app {
namespace {

constexpr const char* kTrainFooter =
    "Examples:\n"
    "  imslam route train --agents 10 --cities 100             from nothing, control variate\n"
    "  imslam route train --agents 5 --cities 50 --estimator sample_baseline --set samples=10\n"
    "  imslam route train --agents 10 --cities 100 --resume    go on after a stop, bit by bit";

struct RouteTrainArguments : TrainArguments {
  std::string agents;
  std::string cities;
  std::string estimator;
};

/// --agents M and the like are short for --set agents=M, and come first.
void put_short_forms_first(RouteTrainArguments& arguments) {
  std::vector<std::string> assignments;
  const auto add = [&](const char* key, const std::string& value) {
    if (!value.empty()) assignments.push_back(std::string(key) + "=" + value);
  };
  add("agents", arguments.agents);
  add("cities", arguments.cities);
  add("estimator", arguments.estimator);
  arguments.assignments.insert(arguments.assignments.begin(), assignments.begin(),
                               assignments.end());
}

void add_train(CLI::App& parent, Action& action, const CommonOptions& common) {
  auto* command = parent.add_subcommand("train", "Train the network that shares the cities out");
  command->footer(kTrainFooter);
  auto arguments = std::make_shared<RouteTrainArguments>();
  arguments->out = "runs/train_route";
  command->add_option("--agents", arguments->agents, "Agents of the network");
  command->add_option("--cities", arguments->cities, "Cities of each instance, with the depot");
  command->add_option("--estimator", arguments->estimator,
                      "constant_baseline, sample_baseline, control_variate or alternating");
  add_training_options(*command, *arguments);
  command->callback([&action, arguments, &common] {
    action = [arguments, &common] {
      put_short_forms_first(*arguments);
      return train<routing::RoutingTraining, routing::RoutingTrainingOptions>("route train",
                                                                              *arguments, common);
    };
  });
}

}  // namespace

std::vector<double> positive_numbers(const std::string& option, const std::string& text) {
  std::vector<double> numbers;
  for (const std::string_view word : split(text, ',')) {
    const auto number = parse_double(word);
    if (!number || !(*number > 0.0) || *number > 1e6) {
      throw InputError(
          fmt::format("{} {}: expected positive numbers with commas between", option, text),
          ExitCode::kUsage);
    }
    numbers.push_back(*number);
  }
  return numbers;
}

std::vector<int> whole_numbers(const std::string& option, const std::string& text) {
  std::vector<int> numbers;
  for (const double number : positive_numbers(option, text)) {
    numbers.push_back(static_cast<int>(number));
  }
  return numbers;
}

routing::Instance numbered_instance(int cities, int seed, int index) {
  Random random = Random(static_cast<std::uint64_t>(seed)).fork(static_cast<std::uint64_t>(index));
  return routing::random_instance(cities, random);
}

void add_route_command(CLI::App& app, Action& action, const CommonOptions& common) {
  auto* command = app.add_subcommand("route", "Tours of several agents, the longest one short");
  command->require_subcommand(1);
  add_route_solve(*command, action, common);
  add_train(*command, action, common);
  add_route_bench(*command, action, common);
  add_route_variance(*command, action, common);
}

}  // namespace imslam::app
