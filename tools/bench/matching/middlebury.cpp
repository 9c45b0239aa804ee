#include <algorithm>
#include <cmath>

#include "slam/base/error.hpp"
#include "tools/bench/matching/true_visibility.hpp"
#include "tools/bench/matching/truth_files.hpp"
#include "tools/bench/matching/yardsticks.hpp"

namespace imslam::bench {
namespace {

namespace fs = std::filesystem;

constexpr float kUnknown = 1e9F;  // the file's sign for it, from here on

MatchScene read_scene(const fs::path& folder) {
  MatchScene scene = scene_around(folder.filename().string(), read_gray(folder / "frame10.png"));
  training::Triplet& t = scene.views;
  t.left1 = view_of(scene, read_gray(folder / "frame11.png"));
  scene.has_flow = true;
  const fs::path file = folder / "flow10.flo";
  const TruthImage<float, 2> flow = read_flo(file);
  expect_truth_size(scene, flow.width, flow.height, file);
  for (int row = 0; row < t.camera.height; ++row) {
    for (int column = 0; column < t.camera.width; ++column) {
      const auto& [u, v] = flow.at(row, column);
      if (!(std::abs(u) < kUnknown && std::abs(v) < kUnknown)) continue;
      const std::size_t at = t.index(row, column);
      t.flow_u[at] = u;
      t.flow_v[at] = v;
      t.flow_state[at] = training::MatchState::kVisible;
    }
  }
  mark_hidden(vo::MatchKind::kFlow, scene);
  return scene;
}

}  // namespace

std::vector<MatchScene> read_middlebury(const fs::path& folder, int frames) {
  std::vector<fs::path> folders;
  if (fs::is_directory(folder)) {
    for (const auto& entry : fs::directory_iterator(folder)) {
      if (fs::exists(entry.path() / "flow10.flo")) folders.push_back(entry.path());
    }
  }
  if (folders.empty()) {
    throw InputError(folder.string() + ": expected folders with flow10.flo of Middlebury");
  }
  std::sort(folders.begin(), folders.end());
  std::vector<MatchScene> scenes;
  for (const int i : evenly_spread(static_cast<int>(folders.size()), frames)) {
    scenes.push_back(read_scene(folders[static_cast<std::size_t>(i)]));
  }
  return scenes;
}

}  // namespace imslam::bench
