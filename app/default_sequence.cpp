#include "app/default_sequence.hpp"

#include "datasets/simulation/simulate.hpp"
#include "slam/base/config.hpp"
#include "slam/base/error.hpp"
#include "slam/base/file.hpp"
#include "slam/base/log.hpp"
#include "slam/base/progress.hpp"

namespace imslam::app {
namespace fs = std::filesystem;
namespace {

/// Written last: a folder without it is a leftover of an interrupted rendering.
constexpr const char* kStamp = "complete.yaml";

bool made_with(const fs::path& folder, const std::string& recipe) {
  return fs::exists(folder / kStamp) && read_file(folder / kStamp) == recipe;
}

}  // namespace

fs::path make_default_sequence(const fs::path& runs_root, bool quiet) {
  const fs::path folder = runs_root / "default_sequence";
  auto options = simulation::default_sequence_options();
  options.force = true;
  Config config;
  config.section("simulation", options);
  const std::string recipe = config.to_yaml();
  if (made_with(folder, recipe)) return folder;

  log::info("rendering the built-in sequence once into {}", folder.string());
  fs::remove_all(folder);
  ProgressBar bar("render", !quiet);
  simulation::simulate(options, folder,
                       [&](std::size_t done, std::size_t total) { bar.update(done, total); });
  write_file_atomic(folder / kStamp, recipe);
  return folder;
}

}  // namespace imslam::app
