#include <fmt/format.h>

#include "slam/base/error.hpp"
#include "tools/bench/matching/true_visibility.hpp"
#include "tools/bench/matching/truth_files.hpp"
#include "tools/bench/matching/yardsticks.hpp"

namespace imslam::bench {
namespace {

namespace fs = std::filesystem;
using training::MatchState;
using vo::MatchKind;

constexpr float kFocalLength = 320.0F;  // [px]
constexpr float kBaseline_m = 0.25F;

fs::path image_of(const fs::path& folder, char side, int frame) {
  return folder / fmt::format("image_{}cam_front", side) /
         fmt::format("{:06}_{}cam_front.png", frame, side);
}

void add_stereo(const fs::path& folder, int frame, MatchScene& scene) {
  training::Triplet& t = scene.views;
  const fs::path file =
      folder / "depth_lcam_front" / fmt::format("{:06}_lcam_front_depth.png", frame);
  const TruthImage<float, 1> depth = read_float_png(file);
  expect_truth_size(scene, depth.width, depth.height, file);
  t.right0 = view_of(scene, read_gray(image_of(folder, 'r', frame)));
  scene.has_stereo = true;
  for (int row = 0; row < t.camera.height; ++row) {
    for (int column = 0; column < t.camera.width; ++column) {
      const float depth_m = depth.at(row, column)[0];
      if (!(depth_m > 0.0F)) continue;
      t.disparity[t.index(row, column)] = kFocalLength * kBaseline_m / depth_m;
      t.disparity_state[t.index(row, column)] = MatchState::kVisible;
    }
  }
  mark_hidden(MatchKind::kStereo, scene);
}

void add_flow(const fs::path& folder, int frame, MatchScene& scene) {
  training::Triplet& t = scene.views;
  const fs::path file =
      folder / "flow_lcam_front" / fmt::format("{:06}_{:06}_flow.png", frame, frame + 1);
  const TruthImage<std::uint16_t, 3> flow = read_uint16x3_png(file);
  expect_truth_size(scene, flow.width, flow.height, file);
  t.left1 = view_of(scene, read_gray(image_of(folder, 'l', frame + 1)));
  scene.has_flow = true;
  for (int row = 0; row < t.camera.height; ++row) {
    for (int column = 0; column < t.camera.width; ++column) {
      const auto& [u, v, mask] = flow.at(row, column);
      if (mask != 0) continue;
      const std::size_t at = t.index(row, column);
      t.flow_u[at] = decoded_flow(u);
      t.flow_v[at] = decoded_flow(v);
      t.flow_state[at] = MatchState::kVisible;
    }
  }
  mark_hidden(MatchKind::kFlow, scene);
}

}  // namespace

std::vector<MatchScene> read_tartanair(const fs::path& folder, int frames) {
  int available = 0;
  while (fs::exists(image_of(folder, 'l', available))) ++available;
  if (available == 0) {
    throw InputError(image_of(folder, 'l', 0).string() + ": expected a trajectory of TartanAir V2");
  }
  std::vector<MatchScene> scenes;
  for (const int frame : evenly_spread(available, frames)) {
    scenes.push_back(
        scene_around(fmt::format("{:06}", frame), read_gray(image_of(folder, 'l', frame))));
    add_stereo(folder, frame, scenes.back());
    if (frame + 1 < available) add_flow(folder, frame, scenes.back());
  }
  return scenes;
}

}  // namespace imslam::bench
