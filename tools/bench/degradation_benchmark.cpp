// How accuracy falls as images get worse: every condition of sequence_conditions.hpp at severities
// 1 to 5, for several front ends.
//
//   degradation_benchmark IMSLAM FOLDER [--front-ends klt,learned] [--conditions dark,noise,...]
//                         [--severities 1,2,3,4,5] [--json FILE] [--more='--imu off']
//
// FOLDER: a EuRoC folder with truth, e.g. made by `imslam simulate`. ATE (SE3) of vision alone and
// of the graph in millimetres; in brackets the frames where vision failed. The seed is fixed: same
// folder, same table.
#include <fmt/format.h>
#include <fmt/ranges.h>
#include <unistd.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <vector>

#include "tools/bench/sequence_conditions.hpp"

namespace imslam::bench {
namespace {

namespace fs = std::filesystem;

struct Settings {
  std::string imslam;
  fs::path folder;
  std::vector<std::string> front_ends{"klt", "learned"};
  std::vector<std::string> conditions;
  std::vector<int> severities{1, 2, 3, 4, 5};
  std::vector<std::string> more;
  fs::path json;
};

struct Outcome {
  std::optional<double> vo_m;  ///< empty: nothing that could be evaluated came out
  std::optional<double> graph_m;
  int failures = 0;
};

std::optional<double> ate(const nlohmann::json& metrics, const char* part) {
  if (!metrics.contains(part)) return std::nullopt;
  const auto& number = metrics.at(part).at("ate_se3_rmse_m");
  return number.is_null() ? std::nullopt : std::optional(number.get<double>());
}

Outcome run(const Settings& settings,
            const std::string& front_end,
            const fs::path& folder,
            const fs::path& out) {
  fs::remove_all(out);
  const std::string command = fmt::format(
      "'{}' run '{}' --quiet --front-end {} --out '{}' {} >/dev/null 2>&1", settings.imslam,
      folder.string(), front_end, out.string(), fmt::join(settings.more, " "));
  if (std::system(command.c_str()) == -1) throw std::runtime_error("cannot run " + settings.imslam);
  std::ifstream stream(out / "metrics.json");
  if (!stream) return {};
  const auto metrics = nlohmann::json::parse(stream);
  return {ate(metrics, "vo"), ate(metrics, "graph"),
          metrics.at("counters").at("vo_failures").get<int>()};
}

std::string text(const std::optional<double>& metres) {
  return metres ? fmt::format("{:.1f}", 1e3 * *metres) : "lost";
}

/// One row of the table, and the same for machines.
void print_row(const Settings& settings,
               const std::string& name,
               int severity,
               const fs::path& folder,
               const fs::path& out,
               nlohmann::json& all) {
  fmt::print("| {} {} |", name, severity == 0 ? "" : std::to_string(severity));
  for (const std::string& front_end : settings.front_ends) {
    const Outcome outcome = run(settings, front_end, folder, out);
    fmt::print(" {} ({}) | {} |", text(outcome.vo_m), outcome.failures, text(outcome.graph_m));
    nlohmann::json row{{"condition", name},
                       {"severity", severity},
                       {"front_end", front_end},
                       {"vo_failures", outcome.failures}};
    row["vo_ate_m"] = outcome.vo_m ? nlohmann::json(*outcome.vo_m) : nlohmann::json();
    row["graph_ate_m"] = outcome.graph_m ? nlohmann::json(*outcome.graph_m) : nlohmann::json();
    all.push_back(row);
  }
  fmt::print("\n");
  std::fflush(stdout);
}

void print_table(const Settings& settings) {
  const fs::path scratch = fs::temp_directory_path() / fmt::format("imslam_bench_{}", ::getpid());
  fs::create_directories(scratch);
  std::string head = "| ATE [mm] |";
  std::string line = "|---|";
  for (const std::string& front_end : settings.front_ends) {
    head += fmt::format(" {} VO (failures) | {} graph |", front_end, front_end);
    line += "---|---|";
  }
  fmt::print("{}\n{}\n", head, line);
  nlohmann::json all = nlohmann::json::array();
  print_row(settings, "clean", 0, settings.folder, scratch / "run", all);
  for (const SequenceCondition& condition : sequence_conditions()) {
    const bool wanted =
        settings.conditions.empty() ||
        std::count(settings.conditions.begin(), settings.conditions.end(), condition.name) > 0;
    for (const int severity : wanted ? settings.severities : std::vector<int>()) {
      fs::remove_all(scratch / "spoiled");
      condition.spoil(settings.folder, scratch / "spoiled", severity);
      print_row(settings, condition.name, severity, scratch / "spoiled", scratch / "run", all);
    }
  }
  fs::remove_all(scratch);
  if (!settings.json.empty()) std::ofstream(settings.json) << all.dump(1) << '\n';
}

}  // namespace
}  // namespace imslam::bench

int main(int argc, char** argv) {
  imslam::bench::Settings settings;
  CLI::App app("Accuracy of imslam under worse and worse images");
  app.add_option("imslam", settings.imslam, "The executable")->required();
  app.add_option("folder", settings.folder, "EuRoC folder with truth")->required();
  app.add_option("--front-ends", settings.front_ends)->delimiter(',');
  app.add_option("--conditions", settings.conditions)->delimiter(',');
  app.add_option("--severities", settings.severities)->delimiter(',')->check(CLI::Range(1, 5));
  app.add_option("--json", settings.json);
  app.add_option("--more", settings.more, "More arguments of imslam run, e.g. --more='--imu off'");
  CLI11_PARSE(app, argc, argv);
  try {
    imslam::bench::print_table(settings);
  } catch (const std::exception& error) {
    fmt::print(stderr, "{}\n", error.what());
    return 1;
  }
  return 0;
}
