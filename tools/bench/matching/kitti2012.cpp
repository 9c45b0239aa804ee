#include <algorithm>

#include "slam/base/error.hpp"
#include "tools/bench/matching/truth_files.hpp"
#include "tools/bench/matching/yardsticks.hpp"

namespace imslam::bench {
namespace {

namespace fs = std::filesystem;

std::vector<std::string> file_names(const fs::path& folder) {
  if (!fs::is_directory(folder)) {
    throw InputError(folder.string() + ": expected a folder of KITTI 2012 stereo");
  }
  std::vector<std::string> names;
  for (const auto& entry : fs::directory_iterator(folder)) {
    if (entry.path().extension() == ".png") names.push_back(entry.path().filename().string());
  }
  std::sort(names.begin(), names.end());
  return names;
}

void add_disparity(const fs::path& file, MatchScene& scene) {
  constexpr float kSteps = 256.0F;  // per pixel
  const TruthImage<std::uint16_t, 1> truth = read_uint16_png(file);
  training::Triplet& t = scene.views;
  expect_truth_size(scene, truth.width, truth.height, file);
  for (int row = 0; row < t.camera.height; ++row) {
    for (int column = 0; column < t.camera.width; ++column) {
      const std::uint16_t value = truth.at(row, column)[0];
      if (value == 0) continue;
      const std::size_t at = t.index(row, column);
      t.disparity[at] = static_cast<float>(value) / kSteps;
      t.disparity_state[at] = training::MatchState::kVisible;  // "noc": seen by both cameras
    }
  }
}

}  // namespace

std::vector<MatchScene> read_kitti2012(const fs::path& folder, int frames) {
  const std::vector<std::string> names = file_names(folder / "disp_noc");
  std::vector<MatchScene> scenes;
  for (const int i : evenly_spread(static_cast<int>(names.size()), frames)) {
    const std::string& name = names[static_cast<std::size_t>(i)];
    scenes.push_back(scene_around(name, read_gray(folder / "image_0" / name)));
    scenes.back().views.right0 = view_of(scenes.back(), read_gray(folder / "image_1" / name));
    scenes.back().has_stereo = true;
    add_disparity(folder / "disp_noc" / name, scenes.back());
  }
  return scenes;
}

}  // namespace imslam::bench
