#include "tools/bench/matching/moving_patches.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "tests/bench/match_scenes.hpp"

namespace imslam::bench {
namespace {

using imslam::testing::textured_scene;
using training::MatchState;
using vo::MatchKind;

MovingPatch patch_in_the_middle() {
  MovingPatch patch;
  patch.x = 40.0;
  patch.y = 20.0;
  patch.width = 20;
  patch.height = 16;
  patch.source_x = 5;
  patch.source_y = 30;
  patch.disparity = 9.25;
  patch.flow_u = -6.5;
  patch.flow_v = 5.75;
  return patch;
}

bool inside(const MovingPatch& patch, double u, double v, double margin) {
  return u >= patch.x - 0.5 + margin && u <= patch.x + patch.width - 0.5 - margin &&
         v >= patch.y - 0.5 + margin && v <= patch.y + patch.height - 0.5 - margin;
}

double bilinear(const training::Triplet& t, const std::vector<float>& view, double u, double v) {
  const int column = std::min(static_cast<int>(u), t.camera.width - 2);
  const int row = std::min(static_cast<int>(v), t.camera.height - 2);
  const auto grey = [&](int r, int c) { return double{view[t.index(r, c)]}; };
  const double upper =
      grey(row, column) + (u - column) * (grey(row, column + 1) - grey(row, column));
  const double lower =
      grey(row + 1, column) + (u - column) * (grey(row + 1, column + 1) - grey(row + 1, column));
  return upper + (v - row) * (lower - upper);
}

TEST(MovingPatches, TakeTheirTruthAlong) {
  const MovingPatch patch = patch_in_the_middle();
  MatchScene scene = textured_scene();
  add_patches({patch}, scene);
  for (int row = 0; row < 64; ++row) {
    for (int column = 0; column < 96; ++column) {
      const bool on_patch = inside(patch, column, row, 0.0);
      const TrueMatch flow = true_match(scene, MatchKind::kFlow, row, column);
      const TrueMatch stereo = true_match(scene, MatchKind::kStereo, row, column);
      EXPECT_EQ(flow.du, on_patch ? -6.5 : 3.0);
      EXPECT_EQ(flow.dv, on_patch ? 5.75 : -2.0);
      EXPECT_EQ(stereo.du, on_patch ? -9.25 : -4.0);
      const bool covered_later =
          !on_patch && inside(patch, column + flow.du + 6.5, row + flow.dv - 5.75, 0.0);
      EXPECT_EQ(flow.state == MatchState::kHidden, covered_later) << row << ' ' << column;
      const bool covered_right = !on_patch && inside(patch, column + stereo.du + 9.25, row, 0.0);
      EXPECT_EQ(stereo.state == MatchState::kHidden, covered_right) << row << ' ' << column;
    }
  }
}

/// The truth after patches moved in leads from every visible point to the same grey, except within
/// 2 px of a patch's border, where two surfaces share a pixel.
TEST(MovingPatches, StandInTheViewsWhereTheTruthSays) {
  const MovingPatch patch = patch_in_the_middle();
  MatchScene scene = textured_scene();
  add_patches({patch}, scene);
  int on_patch = 0;
  for (const MatchKind kind : {MatchKind::kFlow, MatchKind::kStereo}) {
    const std::vector<float>& other = matched_view(scene, kind);
    for (int row = 0; row < 64; ++row) {
      for (int column = 0; column < 96; ++column) {
        const TrueMatch match = true_match(scene, kind, row, column);
        const double u = column + match.du;
        const double v = row + match.dv;
        MovingPatch there = patch;
        there.x += kind == MatchKind::kFlow ? patch.flow_u : -patch.disparity;
        there.y += kind == MatchKind::kFlow ? patch.flow_v : 0.0;
        const bool well_inside = inside(patch, column, row, 2.0);
        const bool well_outside = !inside(patch, column, row, -2.0) && !inside(there, u, v, -2.0);
        if (match.state != MatchState::kVisible || (!well_inside && !well_outside)) continue;
        EXPECT_NEAR(bilinear(scene.views, other, u, v),
                    double{scene.views.left0[scene.views.index(row, column)]}, 2.0)
            << kind_name(kind) << ' ' << row << ' ' << column;
        on_patch += well_inside ? 1 : 0;
      }
    }
  }
  EXPECT_GT(on_patch, 300);
}

TEST(MovingPatches, AreMirroredPiecesOfTheImage) {
  const MovingPatch patch = patch_in_the_middle();
  const MatchScene before = textured_scene();
  MatchScene scene = textured_scene();
  add_patches({patch}, scene);
  const training::Triplet& t = scene.views;
  for (int row = 0; row < patch.height; ++row) {
    for (int column = 0; column < patch.width; ++column) {
      EXPECT_FLOAT_EQ(t.left0[t.index(20 + row, 40 + column)],
                      before.views.left0[t.index(30 + row, 5 + patch.width - 1 - column)]);
    }
  }
}

TEST(MovingPatches, AreTheSameForTheSameSeedAndStandInFrontOfTheScene) {
  const MatchScene scene = textured_scene();
  const std::vector<MovingPatch> few = draw_patches(scene, 3, Random(5));
  const std::vector<MovingPatch> many = draw_patches(scene, 8, Random(5));
  ASSERT_EQ(many.size(), 8U);
  for (std::size_t i = 0; i < few.size(); ++i) {
    EXPECT_EQ(few[i].x, many[i].x);
    EXPECT_EQ(few[i].flow_u, many[i].flow_u);
  }
  for (const MovingPatch& patch : many) {
    EXPECT_GE(patch.disparity, 4.75);
    EXPECT_EQ(std::fmod(patch.flow_u, 0.25), 0.0);
    EXPECT_LE(patch.x + patch.width, 96.0);
    EXPECT_LE(patch.y + patch.height, 64.0);
  }
}

}  // namespace
}  // namespace imslam::bench
