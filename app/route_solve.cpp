#include <fmt/format.h>

#include <CLI/Config.hpp>
#include <CLI/Formatter.hpp>
#include <algorithm>
#include <chrono>
#include <filesystem>
#include <memory>

#include "app/route_command.hpp"
#include "slam/base/text.hpp"
#include "slam/plugins/routing/lower_bound.hpp"
#include "slam/plugins/routing/read_instance.hpp"
#include "slam/plugins/routing/routing_weights.hpp"
#include "slam/plugins/routing/solution.hpp"

namespace imslam::app {
namespace {

namespace fs = std::filesystem;

constexpr const char* kRouteSolveExamples =
    "FILE: TSPLIB (EUC_2D, CEIL_2D, GEO, ATT, EXPLICIT), a line x,y per city, or a table of\n"
    "distances (row: from, column: to; need be neither symmetric nor a metric). Methods:\n"
    "  search          insertion, then ruin and recreate that attacks the longest tour\n"
    "  insertion       each city where it lengthens the longest tours least: milliseconds\n"
    "  network         the trained network shares the cities out, one tour search per agent\n"
    "  network_search  the search from the network's answer, if that is better than insertion\n"
    "With --time alone two calls may differ; --iterations N --time 0 gives the same tours each "
    "time.\n"
    "\n"
    "Examples:\n"
    "  imslam route solve --random 500 --agents 10 --time 2 --out runs/route\n"
    "  imslam route solve cities.csv --agents 3 --depot 7 --iterations 100000 --time 0";

struct SolveArguments {
  std::string file;
  int random = 0;
  int depot = 0;
  routing::SolveOptions options;
  std::string method = "search";
  std::string weights;
  std::string out;
  bool force = false;
};

routing::Instance instance_of(const SolveArguments& arguments) {
  if (arguments.file.empty() == (arguments.random == 0)) {
    throw InputError("give either a file of cities or --random N", ExitCode::kUsage);
  }
  if (!arguments.file.empty()) return routing::read_instance(arguments.file, arguments.depot);
  if (arguments.random > routing::kMostCities) {
    throw InputError(
        fmt::format("--random {}: expected 2 to {}", arguments.random, routing::kMostCities),
        ExitCode::kUsage);
  }
  routing::Instance instance = numbered_instance(arguments.random, arguments.options.seed, 0);
  if (arguments.depot < 0 || arguments.depot >= arguments.random) {
    throw InputError(
        fmt::format("--depot {}: expected 0 to {}", arguments.depot, arguments.random - 1),
        ExitCode::kUsage);
  }
  instance.depot = arguments.depot;
  return instance;
}

void print_solution(const routing::Instance& instance, const routing::Solution& solution) {
  fmt::print("agent  cities  length\n");
  for (std::size_t agent = 0; agent < solution.tours.size(); ++agent) {
    const bool longest = solution.lengths[agent] >= solution.longest();
    fmt::print("{:5}  {:6}  {:.6g}{}\n", agent, solution.tours[agent].size(),
               solution.lengths[agent], longest ? "  longest" : "");
  }
  fmt::print("{}: {} cities, depot {}, {} agents: longest {:.6g}, all {:.6g}\n", instance.name,
             instance.city_count(), instance.depot, solution.tours.size(), solution.longest(),
             solution.total());
}

ExitCode solve_files(const SolveArguments& given) {
  SolveArguments arguments = given;
  const auto& names = routing::method_names();
  const auto found = std::find(names.begin(), names.end(), arguments.method);
  arguments.options.method = static_cast<routing::Method>(found - names.begin());
  const fs::path result = fs::path(arguments.out) / "tours.json";
  if (!arguments.out.empty() && fs::exists(result) && !arguments.force) {
    throw InputError(result.string() + ": exists; --force overwrites it", ExitCode::kOutput);
  }
  const routing::Instance instance = instance_of(arguments);
  std::shared_ptr<const routing::AllocationNetwork<float>> network;
  if (arguments.method == "network" || arguments.method == "network_search") {
    network = routing::load_network(arguments.options.agents, arguments.weights);
  }
  const auto start = std::chrono::steady_clock::now();
  const routing::Solution solution = routing::solve(instance, arguments.options, network.get());
  const std::chrono::duration<double> taken = std::chrono::steady_clock::now() - start;
  print_solution(instance, solution);
  fmt::print("{} in {:.3f} s\n", arguments.method, taken.count());
  if (!arguments.out.empty()) {
    routing::write_solution(arguments.out, instance, solution);
    fmt::print("tours: {}\n", result.string());
  }
  return ExitCode::kOk;
}

}  // namespace

void add_route_solve(CLI::App& parent, Action& action, const CommonOptions&) {
  auto* command = parent.add_subcommand("solve", "Find tours for the cities of a file");
  command->footer(kRouteSolveExamples);
  auto arguments = std::make_shared<SolveArguments>();
  command->add_option("file", arguments->file, "Cities");
  command->add_option("--random", arguments->random, "Instead: N uniform cities, by --seed");
  command->add_option("--agents", arguments->options.agents, "Agents")->required();
  command->add_option("--depot", arguments->depot, "City where tours start, counted from 0")
      ->capture_default_str();
  command->add_option("--time", arguments->options.time_s, "Seconds of search, 0: no limit")
      ->capture_default_str();
  command->add_option("--iterations", arguments->options.iterations,
                      "Of the search, 0: no limit; the same tours each time");
  command
      ->add_option("--chains", arguments->options.chains,
                   "Searches side by side, on the threads there are; the best one counts")
      ->capture_default_str();
  command->add_option("--seed", arguments->options.seed, "Of the search")->capture_default_str();
  command->add_option("--method", arguments->method, "How tours are found")
      ->check(CLI::IsMember(routing::method_names()))
      ->capture_default_str();
  command->add_option("--draws", arguments->options.draws, "Allocations drawn from the network")
      ->capture_default_str();
  command->add_option("--weights", arguments->weights,
                      "Trained network instead of the shipped one");
  command->add_option("--out", arguments->out, "Folder for tours.json, tours.csv, tours.svg");
  command->add_flag("--force", arguments->force, "Overwrite them");
  command->callback(
      [&action, arguments] { action = [arguments] { return solve_files(*arguments); }; });
}

}  // namespace imslam::app
