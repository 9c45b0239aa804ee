#include <fmt/format.h>

#include <CLI/Config.hpp>
#include <CLI/Formatter.hpp>
#include <filesystem>
#include <map>
#include <memory>
#include <nlohmann/json.hpp>
#include <utility>

#include "app/route_command.hpp"
#include "slam/base/file.hpp"
#include "slam/base/progress.hpp"
#include "slam/base/text.hpp"
#include "slam/plugins/routing/lower_bound.hpp"
#include "slam/plugins/routing/routing_weights.hpp"

namespace imslam::app {
namespace {

namespace fs = std::filesystem;
using Network = std::shared_ptr<const routing::AllocationNetwork<float>>;

constexpr const char* kRouteBenchExamples =
    "Every method solves the same random instances (uniform cities, random depot). Rows `paper "
    "...`\n"
    "are published means over other instances, for orientation; nothing of them is run here.\n"
    "Further trained networks get rows of their own: --weights RL=FILE.\n"
    "--processor-time counts what the program had of the processor instead of the wall's seconds,\n"
    "divided by --threads: on machines with other work.\n"
    "\n"
    "Example:\n"
    "  imslam route bench --agents 5,10,15 --cities 400,700,1000 --instances 20 --time 1,5";

struct BenchArguments {
  std::string agents = "5,10,15";
  std::string cities = "400,500,600,700,800,900,1000";
  std::string times = "1";
  int instances = 20;
  int seed = 1;
  bool processor_time = false;
  bool only_searches = false;
  double heat = routing::SolveOptions().heat;
  double network_heat = routing::SolveOptions().network_heat;
  std::vector<std::string> weights;  ///< NAME=FILE
  std::string instances_out;
  std::string out;
};

/// One row of the table.
struct BenchMethod {
  std::string name;
  routing::SolveOptions options;
  Network network;
};

/// Mean of the longest tour of published results, N = 400, 500, ... 1000 (iMTSP's table).
struct Published {
  const char* name;
  int agents;
  std::vector<double> longest;
};
const std::vector<Published>& published() {
  static const std::vector<Published> rows = {
      {"paper iMTSP (trained on 50)", 10, {3.046, 3.273, 3.530, 3.712, 3.924, 4.122, 4.283}},
      {"paper iMTSP (trained on 100)", 10, {3.019, 3.215, 3.424, 3.570, 3.763, 3.930, 4.042}},
      {"paper RL (trained on 100)", 10, {3.035, 3.271, 3.542, 3.737, 3.954, 4.181, 4.330}},
      {"paper OR-Tools", 10, {10.48, 10.20, 12.03, 13.20, 14.12, 18.71, 18.66}},
      {"paper iMTSP (trained on 100)", 15, {2.614, 2.771, 2.944, 3.059, 3.221, 3.340, 3.456}},
      {"paper RL (trained on 100)", 15, {2.718, 2.915, 3.103, 3.242, 3.441, 3.609, 3.730}}};
  return rows;
}

struct Cell {
  double longest = 0.0;
  double seconds = 0.0;
};

void add_network_rows(const std::string& name,
                      const Network& network,
                      const routing::SolveOptions& common,
                      std::vector<BenchMethod>& methods) {
  routing::SolveOptions options = common;
  options.method = routing::Method::kNetwork;
  options.draws = 0;
  methods.push_back({name + ", likeliest", options, network});
  options.draws = 16;
  methods.push_back({name + ", best of 17", options, network});
}

std::vector<BenchMethod> methods_for(int agents, const BenchArguments& arguments) {
  routing::SolveOptions options;
  options.agents = agents;
  options.seed = arguments.seed;
  options.heat = arguments.heat;
  options.network_heat = arguments.network_heat;
  if (arguments.processor_time) options.time_of = routing::TimeOf::kProcessor;
  options.method = routing::Method::kInsertion;
  std::vector<BenchMethod> methods;
  if (!arguments.only_searches) methods.push_back({"insertion", options, nullptr});
  for (const std::string& weights : arguments.weights) {
    const std::size_t equals = weights.find('=');
    const std::string suffix = fmt::format("_{}.safetensors", agents);
    if (equals == std::string::npos || !fs::exists(weights.substr(equals + 1))) {
      throw InputError("--weights " + weights + ": expected NAME=FILE with a file that is there",
                       ExitCode::kModel);
    }
    if (weights.size() < suffix.size() ||
        weights.compare(weights.size() - suffix.size(), suffix.size(), suffix) != 0) {
      continue;  // of other agents
    }
    add_network_rows(weights.substr(0, equals),
                     routing::load_network(agents, weights.substr(equals + 1)), options, methods);
  }
  const bool shipped = routing::shipped_weights(agents).has_value();
  const Network network = shipped ? routing::load_network(agents, "") : nullptr;
  if (network && !arguments.only_searches)
    add_network_rows("shipped network", network, options, methods);
  for (const double time_s : positive_numbers("--time", arguments.times)) {
    options.time_s = time_s;
    options.method = routing::Method::kSearch;
    methods.push_back({fmt::format("search {} s", time_s), options, nullptr});
    if (!network) continue;
    options.method = routing::Method::kNetworkSearch;
    methods.push_back({fmt::format("network + search {} s", time_s), options, network});
  }
  return methods;
}

Cell run_method(const BenchMethod& method, const std::vector<routing::Instance>& instances) {
  Cell cell;
  for (const routing::Instance& instance : instances) {
    const auto clock = routing::clock_from_now(method.options.time_of);
    const double longest = routing::solve(instance, method.options, method.network.get()).longest();
    cell.seconds += clock() / static_cast<double>(instances.size());
    cell.longest += longest / static_cast<double>(instances.size());
  }
  return cell;
}

Cell mean_bound(int agents, const std::vector<routing::Instance>& instances) {
  Cell cell;
  for (const routing::Instance& instance : instances) {
    const routing::Distances distances(instance);
    cell.longest += routing::lower_bound(distances, instance.depot, agents).value() /
                    static_cast<double>(instances.size());
  }
  return cell;
}

/// Rows in the order in which they first came.
class BenchTable {
 public:
  BenchTable(int agents, std::vector<int> cities) : agents_(agents), cities_(std::move(cities)) {}

  void add(const std::string& row, int cities, const Cell& cell) {
    if (cells_.count(row) == 0) order_.push_back(row);
    cells_[row][cities] = cell;
  }
  void add_published() {
    for (const Published& row : published()) {
      if (row.agents != agents_) continue;
      for (const int cities : cities_) {
        if (cities % 100 != 0 || cities < 400 || cities > 1000) continue;
        add(row.name, cities, {row.longest[static_cast<std::size_t>(cities / 100 - 4)], 0.0});
      }
    }
  }
  std::string text() const {
    std::string text =
        fmt::format("{} agents: mean longest tour (mean seconds)\n{:32}", agents_, "");
    for (const int cities : cities_) text += fmt::format("{:>16}", cities);
    for (const std::string& row : order_) {
      text += fmt::format("\n{:32}", row);
      for (const int cities : cities_) {
        const auto cell = cells_.at(row).find(cities);
        if (cell == cells_.at(row).end()) {
          text += fmt::format("{:>16}", "-");
          continue;
        }
        const bool timed = cell->second.seconds > 0.0;
        text += fmt::format("{:>7.3f} {:8}", cell->second.longest,
                            timed ? fmt::format("({:.3f})", cell->second.seconds) : "");
      }
    }
    return text + "\n";
  }
  std::string csv() const {
    std::string text;
    for (const std::string& row : order_) {
      for (const auto& [cities, cell] : cells_.at(row)) {
        text += fmt::format("{},{},{},{:.6f},{:.4f}\n", agents_, cities, csv_field(row),
                            cell.longest, cell.seconds);
      }
    }
    return text;
  }

 private:
  int agents_;
  std::vector<int> cities_;
  std::vector<std::string> order_;
  std::map<std::string, std::map<int, Cell>> cells_;
};

/// For other programs: [{"depot": 0, "points": [[x, y], ...]}, ...]
void export_instances(const fs::path& file, const std::vector<routing::Instance>& instances) {
  std::error_code error;  // a folder that cannot be made is one that cannot be written to
  fs::create_directories(file.parent_path(), error);
  nlohmann::json all = nlohmann::json::array();
  for (const routing::Instance& instance : instances) {
    nlohmann::json points = nlohmann::json::array();
    for (const routing::Point& p : instance.points) points.push_back({p.x, p.y});
    all.push_back({{"depot", instance.depot}, {"points", points}});
  }
  write_file_atomic(file, all.dump());
}

ExitCode bench(const BenchArguments& arguments, bool quiet) {
  const std::vector<int> all_cities = whole_numbers("--cities", arguments.cities);
  std::string csv = "agents,cities,method,longest,seconds\n";
  for (const int agents : whole_numbers("--agents", arguments.agents)) {
    const std::vector<BenchMethod> methods = methods_for(agents, arguments);
    BenchTable table(agents, all_cities);
    ProgressBar bar(fmt::format("{} agents", agents), !quiet);
    std::size_t done = 0;
    for (const int cities : all_cities) {
      std::vector<routing::Instance> instances;
      for (int i = 0; i < arguments.instances; ++i) {
        instances.push_back(numbered_instance(cities, arguments.seed, i));
      }
      if (!arguments.instances_out.empty()) {
        export_instances(fs::path(arguments.instances_out) / fmt::format("{}.json", cities),
                         instances);
      }
      for (const BenchMethod& method : methods) {
        table.add(method.name, cities, run_method(method, instances));
        bar.update(++done, methods.size() * all_cities.size(), method.name);
      }
      table.add("lower bound", cities, mean_bound(agents, instances));
    }
    bar.clear();
    table.add_published();
    csv += table.csv();
    fmt::print("{}\n", table.text());
  }
  fmt::print("{} instances per column, seed {}\n", arguments.instances, arguments.seed);
  if (!arguments.out.empty()) write_file_atomic(arguments.out, csv);
  return ExitCode::kOk;
}

}  // namespace

void add_route_bench(CLI::App& parent, Action& action, const CommonOptions& common) {
  auto* command = parent.add_subcommand("bench", "Compare the methods on random instances");
  command->footer(kRouteBenchExamples);
  auto arguments = std::make_shared<BenchArguments>();
  command->add_option("--agents", arguments->agents, "Numbers of agents")->capture_default_str();
  command->add_option("--cities", arguments->cities, "Numbers of cities, the depot included")
      ->capture_default_str();
  command->add_option("--time", arguments->times, "Seconds of the searches")->capture_default_str();
  command->add_option("--instances", arguments->instances, "Instances per number of cities")
      ->check(CLI::Range(1, 10000))
      ->capture_default_str();
  command->add_option("--seed", arguments->seed, "Of the instances")->capture_default_str();
  command->add_flag("--processor-time", arguments->processor_time,
                    "Seconds are those that the program had of a processor");
  command->add_flag("--only-searches", arguments->only_searches, "No other methods");
  command->add_option("--heat", arguments->heat, "First temperature after insertion")
      ->capture_default_str();
  command->add_option("--network-heat", arguments->network_heat, "Likewise after the network")
      ->capture_default_str();
  command
      ->add_option("--instances-out", arguments->instances_out,
                   "Folder that gets the instances, for other programs")
      ->type_name("FOLDER");
  command
      ->add_option("--weights", arguments->weights,
                   "Networks to compare; agents by the end of the name, _5.safetensors")
      ->type_name("NAME=FILE");
  command->add_option("--out", arguments->out, "The table as csv")->type_name("FILE");
  command->callback([&action, arguments, &common] {
    action = [arguments, &common] { return bench(*arguments, common.quiet); };
  });
}

}  // namespace imslam::app
