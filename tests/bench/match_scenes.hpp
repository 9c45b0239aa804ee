#pragma once

#include <cmath>

#include "tools/bench/matching/scene.hpp"

namespace imslam::testing {

/// A smooth texture, 16 px and more from wave to wave.
inline double texture_at(double u, double v) {
  return 128.0 + 40.0 * std::sin(0.31 * u + 0.17 * v) + 40.0 * std::cos(0.13 * u - 0.35 * v);
}

/// 96 x 64 px; everything has disparity 4 and moves by (3, -2).
inline bench::MatchScene textured_scene() {
  GrayImage image{96, 64, std::vector<std::uint8_t>(96 * 64, 0)};
  bench::MatchScene scene = bench::scene_around("textured", image);
  training::Triplet& t = scene.views;
  for (int row = 0; row < 64; ++row) {
    for (int column = 0; column < 96; ++column) {
      const std::size_t at = t.index(row, column);
      t.left0[at] = static_cast<float>(texture_at(column, row));
      t.right0[at] = static_cast<float>(texture_at(column + 4.0, row));
      t.left1[at] = static_cast<float>(texture_at(column - 3.0, row + 2.0));
      t.disparity[at] = 4.0F;
      t.flow_u[at] = 3.0F;
      t.flow_v[at] = -2.0F;
      const bool right = column >= 4;
      const bool left = column + 3 <= 95 && row >= 2;
      t.disparity_state[at] =
          right ? training::MatchState::kVisible : training::MatchState::kOutside;
      t.flow_state[at] = left ? training::MatchState::kVisible : training::MatchState::kOutside;
    }
  }
  scene.has_flow = scene.has_stereo = true;
  return scene;
}

}  // namespace imslam::testing
