#include "tools/bench/matching/true_visibility.hpp"

#include <gtest/gtest.h>

namespace imslam::bench {
namespace {

using training::MatchState;
using vo::MatchKind;

/// 64 x 8 px of disparity 2; the columns 30 to 39 stand in front with 12. Flow is the opposite of
/// disparity: all truths are believed visible.
MatchScene two_layers() {
  MatchScene scene =
      scene_around("two layers", GrayImage{64, 8, std::vector<std::uint8_t>(64 * 8, 100)});
  training::Triplet& t = scene.views;
  for (int row = 0; row < 8; ++row) {
    for (int column = 0; column < 64; ++column) {
      const std::size_t at = t.index(row, column);
      t.disparity[at] = column >= 30 && column < 40 ? 12.0F : 2.0F;
      t.flow_u[at] = -t.disparity[at];
      t.disparity_state[at] = t.flow_state[at] = MatchState::kVisible;
    }
  }
  scene.has_flow = scene.has_stereo = true;
  return scene;
}

/// Front points land in 18 to 27; those behind land there from columns 20 to 29. Whole
/// displacements touch one pixel more.
MatchState expected(int column) {
  if (column < 2) return MatchState::kOutside;
  return column >= 20 && column < 30 ? MatchState::kHidden : MatchState::kVisible;
}

TEST(TrueVisibility, WhatLandsBehindANearerPointIsHidden) {
  MatchScene scene = two_layers();
  mark_hidden(MatchKind::kStereo, scene);
  mark_hidden(MatchKind::kFlow, scene);
  for (int column = 0; column < 64; ++column) {
    if (column == 19) continue;  // lands beside the front, which reaches into its neighbour
    const std::size_t at = scene.views.index(4, column);
    EXPECT_EQ(scene.views.disparity_state[at], expected(column)) << column;
    EXPECT_EQ(scene.views.flow_state[at], expected(column)) << column;
  }
}

TEST(TrueVisibility, WithoutDepthBothLayersAreDoubtful) {
  MatchScene scene = two_layers();
  scene.has_stereo = false;
  scene.views.disparity.assign(scene.views.disparity.size(), 0.0F);
  mark_hidden(MatchKind::kFlow, scene);
  for (const int column : {22, 25, 28, 32, 35, 38}) {
    EXPECT_EQ(scene.views.flow_state[scene.views.index(4, column)], MatchState::kHidden) << column;
  }
  for (const int column : {5, 15, 45, 60}) {
    EXPECT_EQ(scene.views.flow_state[scene.views.index(4, column)], MatchState::kVisible) << column;
  }
}

TEST(TrueVisibility, ASlantedSurfaceDoesNotHideItself) {
  MatchScene scene = two_layers();
  training::Triplet& t = scene.views;
  for (int row = 0; row < 8; ++row) {
    for (int column = 0; column < 64; ++column) {
      t.disparity[t.index(row, column)] = 2.0F + 0.3F * static_cast<float>(column);
    }
  }
  mark_hidden(MatchKind::kStereo, scene);
  for (int column = 8; column < 64; ++column) {
    EXPECT_EQ(t.disparity_state[t.index(4, column)], MatchState::kVisible) << column;
  }
}

TEST(TrueVisibility, OtherStatesStay) {
  MatchScene scene = two_layers();
  scene.views.disparity_state[scene.views.index(4, 32)] = MatchState::kNone;
  mark_hidden(MatchKind::kStereo, scene);
  EXPECT_EQ(scene.views.disparity_state[scene.views.index(4, 32)], MatchState::kNone);
}

}  // namespace
}  // namespace imslam::bench
