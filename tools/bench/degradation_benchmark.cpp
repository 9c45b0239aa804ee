// How accuracy falls as images get worse: every degradation of tests/support/degradation.hpp at
// severities 1 to 5, as the error of the graph over that of the unspoiled run.
//
//   degradation_benchmark IMSLAM FOLDER [NAME...]
//
// FOLDER: a EuRoC folder with truth, e.g. made by `imslam simulate`. NAME: only these degradations.
// The seed is fixed: same folder, same table.
#include <fmt/format.h>
#include <unistd.h>

#include <algorithm>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <vector>

#include "tests/support/degradation.hpp"

namespace imslam {
namespace {

namespace fs = std::filesystem;

struct Outcome {
  std::optional<double> ate_m;  ///< empty: nothing that could be evaluated came out
  int failures = 0;             ///< of vision, and frames that are degraded
};

Outcome run(const std::string& imslam, const fs::path& folder, const fs::path& out) {
  fs::remove_all(out);
  const std::string command = fmt::format("'{}' run '{}' --quiet --out '{}' >/dev/null", imslam,
                                          folder.string(), out.string());
  if (std::system(command.c_str()) == -1) throw std::runtime_error("cannot run " + imslam);
  std::ifstream stream(out / "metrics.json");
  const auto metrics = nlohmann::json::parse(stream);
  const auto& counters = metrics.at("counters");
  const auto& ate_m = metrics.at("graph").at("ate_se3_rmse_m");
  return {ate_m.is_null() ? std::nullopt : std::optional(ate_m.get<double>()),
          counters.at("vo_failures").get<int>() + counters.at("frames_degraded").get<int>()};
}

void print_table(const std::string& imslam,
                 const fs::path& folder,
                 const std::vector<std::string>& names) {
  const fs::path scratch = fs::temp_directory_path() / fmt::format("imslam_bench_{}", ::getpid());
  fs::create_directories(scratch);
  const Outcome clean = run(imslam, folder, scratch / "run");
  if (!clean.ate_m) throw std::runtime_error("the unspoiled run has no error: is there a truth?");
  fmt::print("unspoiled: ATE {:.4f} m. Error over the unspoiled one (failed frames):\n{:<10}",
             *clean.ate_m, "severity");
  for (int severity = 1; severity <= 5; ++severity) fmt::print("{:>14}", severity);
  fmt::print("\n");
  for (const testing::Degradation& degradation : testing::degradations()) {
    const bool wanted = names.empty() || std::count(names.begin(), names.end(), degradation.name);
    if (!wanted) continue;
    fmt::print("{:<10}", degradation.name);
    for (int severity = 1; severity <= 5; ++severity) {
      fs::remove_all(scratch / "spoiled");
      testing::Chaos chaos(folder, scratch / "spoiled");
      degradation.spoil(chaos, severity);
      const Outcome spoiled = run(imslam, chaos.folder(), scratch / "run");
      const std::string ratio =
          spoiled.ate_m ? fmt::format("{:.2f}", *spoiled.ate_m / *clean.ate_m) : "lost";
      fmt::print("{:>8} {:<5}", ratio, fmt::format("({})", spoiled.failures));
      std::fflush(stdout);
    }
    fmt::print("\n");
  }
  fs::remove_all(scratch);
}

}  // namespace
}  // namespace imslam

int main(int argc, char** argv) {
  if (argc < 3) {
    fmt::print(stderr, "degradation_benchmark IMSLAM FOLDER [NAME...]\n");
    return 2;
  }
  try {
    imslam::print_table(argv[1], argv[2], {argv + 3, argv + argc});
  } catch (const std::exception& error) {
    fmt::print(stderr, "{}\n", error.what());
    return 1;
  }
  return 0;
}
