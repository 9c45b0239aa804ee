// How well points are found again: end point errors of flow and disparity of our KLT, OpenCV's DIS
// and StereoSGBM and the matching network, on images as they are and on spoiled ones.
//
//   matching_benchmark [--data FOLDER] [--datasets tartanair,kitti2012,middlebury,simulated]
//                      [--simulated FOLDER]... [--methods klt,dis,sgbm,network] [--weights FILE]
//                      [--conditions clean,motion_blur,dark,brighter,darker,noise,moving]
//                      [--frames N] [--json FILE] [--seed N] [--threads N]
//
// FOLDER of --data holds the excerpts described in tools/bench/matching/yardsticks.hpp; those of
// --simulated are made by `imslam simulate FOLDER --set truth_depth=true --set truth_flow=true`.
// Queries: corners of the clean left image whose truth is known and visible, the same for all
// methods; those that a moving patch covers in any view are left out. Same arguments, same tables,
// whatever the number of threads.
#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <opencv2/core.hpp>

#include "slam/base/error.hpp"
#include "slam/base/parallel.hpp"
#include "tests/support/test_data.hpp"
#include "tools/bench/matching/experiment.hpp"
#include "tools/bench/matching/tables.hpp"
#include "tools/bench/matching/yardsticks.hpp"

namespace imslam::bench {
namespace {

namespace fs = std::filesystem;
using Names = std::vector<std::string>;

struct Settings {
  fs::path data = testing::test_data();
  Names datasets{"tartanair", "kitti2012", "middlebury", "simulated"};
  std::vector<fs::path> simulated;
  Names conditions{"clean", "motion_blur", "dark", "brighter", "darker", "noise", "moving"};
  Names methods{"klt", "dis", "sgbm", "network"};
  fs::path weights;
  fs::path json;
  int frames = 6;
  int threads = 0;
  std::uint64_t seed = 1;
};

bool among(const std::string& name, const Names& names) {
  return std::find(names.begin(), names.end(), name) != names.end();
}

std::vector<DataSet> read_data(const Settings& s) {
  std::vector<DataSet> data;
  if (among("tartanair", s.datasets)) {
    data.push_back({"tartanair", read_tartanair(s.data / "tartanair_p000_excerpt", s.frames)});
  }
  if (among("kitti2012", s.datasets)) {
    data.push_back({"kitti2012", read_kitti2012(s.data / "kitti2012_stereo_excerpt", s.frames)});
  }
  if (among("middlebury", s.datasets)) {
    data.push_back({"middlebury", read_middlebury(s.data / "middlebury_flow_excerpt", s.frames)});
  }
  if (!among("simulated", s.datasets)) return data;
  for (const fs::path& folder : s.simulated) {
    data.push_back({folder.filename().string(), read_simulated(folder, s.frames)});
  }
  return data;
}

std::vector<std::unique_ptr<Method>> make_methods(const Settings& s) {
  std::vector<std::unique_ptr<Method>> methods;
  if (among("klt", s.methods)) methods.push_back(make_klt());
  if (among("dis", s.methods)) methods.push_back(make_dis());
  if (among("sgbm", s.methods)) methods.push_back(make_sgbm());
  if (among("network", s.methods) && !s.weights.empty()) {
    methods.push_back(make_network(s.weights));
  }
  return methods;
}

std::vector<Trial> make_trials(const Settings& s) {
  std::vector<Trial> trials;
  if (among("clean", s.conditions)) trials.push_back({{"clean", "", {}, nullptr}, 0});
  for (const Condition& condition : conditions()) {
    if (!among(condition.name, s.conditions)) continue;
    for (std::size_t i = 1; i <= kSeverities; ++i)
      trials.push_back({condition, static_cast<int>(i)});
  }
  return trials;
}

/// Throws if a truth does not explain its images: nothing measured with it would mean anything.
void check(const std::vector<DataSet>& data) {
  fmt::print(
      "### Truth, checked by warping: median grey residual\n\n"
      "| data | kind | scenes | points | truth | truth + 1 px | no motion | |\n"
      "|---|---|---|---|---|---|---|---|\n");
  bool all_hold = true;
  for (const DataSet& set : data) {
    std::vector<CheckedKind> checks;
    for (const vo::MatchKind kind : {vo::MatchKind::kFlow, vo::MatchKind::kStereo}) {
      const WarpCheck warped = check_by_warping(set.scenes, kind);
      if (warped.points == 0) continue;
      checks.push_back({kind, warped});
      all_hold = all_hold && warped.holds();
    }
    print_checks(set, checks);
  }
  fmt::print("\n");
  std::fflush(stdout);
  if (!all_hold) throw InputError("a truth does not fit its images, see the table");
}

void run(const Settings& settings) {
  set_thread_count(settings.threads);
  cv::setNumThreads(1);  // scenes run in parallel, OpenCV's answers do not depend on chance
  const auto methods = make_methods(settings);
  const std::vector<Trial> trials = make_trials(settings);
  const std::vector<DataSet> data = read_data(settings);
  check(data);
  std::vector<Summary> all;
  for (const DataSet& set : data) {
    const std::vector<Summary> summaries =
        summarised(set.name, measure(set, trials, methods, settings.seed));
    print_tables(summaries);
    std::fflush(stdout);
    all.insert(all.end(), summaries.begin(), summaries.end());
  }
  if (!settings.json.empty()) write_json(settings.json, all);
}

CLI::Option* add_choice(CLI::App& app, const char* flag, Names& names) {
  return app.add_option(flag, names)->delimiter(',')->check(CLI::IsMember(names));
}

}  // namespace
}  // namespace imslam::bench

int main(int count, char** arguments) {
  using namespace imslam;
  CLI::App app("End point errors of flow and disparity: KLT, DIS, SGBM and the matching network");
  bench::Settings settings;
  app.add_option("--data", settings.data, "folder of the excerpts");
  bench::add_choice(app, "--datasets", settings.datasets);
  app.add_option("--simulated", settings.simulated, "folders of imslam simulate");
  bench::add_choice(app, "--conditions", settings.conditions);
  bench::add_choice(app, "--methods", settings.methods);
  app.add_option("--weights", settings.weights,
                 "of the network; without it the network is left out");
  app.add_option("--json", settings.json, "write all numbers into this file");
  app.add_option("--frames", settings.frames, "scenes per data set at most")
      ->check(CLI::Range(1, 100000));
  app.add_option("--threads", settings.threads, "0: all cores")->check(CLI::Range(0, 1024));
  app.add_option("--seed", settings.seed);
  CLI11_PARSE(app, count, arguments);
  try {
    bench::run(settings);
  } catch (const InputError& error) {
    fmt::print(stderr, "{}\n", error.what());
    return static_cast<int>(error.code());
  }
  return 0;
}
