#include "slam/training/occluders.hpp"

#include <gtest/gtest.h>

#include "slam/base/error.hpp"
#include "tests/slam/training/samples.hpp"

namespace imslam::training {
namespace {

/// An even grey world in the distance that moves by (3, -2) px.
Triplet plain_triplet() {
  Triplet t;
  t.camera.width = 64;
  t.camera.height = 48;
  const std::size_t pixels = 64 * 48;
  t.left0 = t.right0 = t.left1 = std::vector<float>(pixels, 100.0F);
  t.disparity.assign(pixels, 4.0F);
  t.flow_u.assign(pixels, 3.0F);
  t.flow_v.assign(pixels, -2.0F);
  t.disparity_state.assign(pixels, MatchState::kVisible);
  t.flow_state.assign(pixels, MatchState::kVisible);
  return t;
}

Occluder dark_box() {
  Occluder occluder;
  occluder.x = 19.5;
  occluder.y = 9.5;
  occluder.width = 10.0;
  occluder.height = 6.0;
  occluder.disparity = 8.0;
  occluder.flow_u = -5.0;
  occluder.flow_v = 7.0;
  occluder.grey = 0.0F;
  return occluder;
}

TEST(Occluders, StandWhereTheirDisparityAndFlowPutThem) {
  Triplet t = plain_triplet();
  add_occluders({dark_box()}, t);
  for (int row = 0; row < 48; ++row) {
    for (int column = 0; column < 64; ++column) {
      const std::size_t at = t.index(row, column);
      const auto in = [&](int u, int v) {
        return column >= 20 + u && column < 30 + u && row >= 10 + v && row < 16 + v;
      };
      EXPECT_EQ(t.left0[at], in(0, 0) ? 0.0F : 100.0F);
      EXPECT_EQ(t.right0[at], in(-8, 0) ? 0.0F : 100.0F);
      EXPECT_EQ(t.left1[at], in(-5, 7) ? 0.0F : 100.0F);
      EXPECT_EQ(t.disparity[at], in(0, 0) ? 8.0F : 4.0F);
      EXPECT_EQ(t.flow_u[at], in(0, 0) ? -5.0F : 3.0F);
      EXPECT_EQ(t.flow_v[at], in(0, 0) ? 7.0F : -2.0F);
    }
  }
}

TEST(Occluders, HideWhatTheyMoveInFrontOf) {
  Triplet t = plain_triplet();
  add_occluders({dark_box()}, t);
  for (int row = 0; row < 48; ++row) {
    for (int column = 0; column < 64; ++column) {
      const std::size_t at = t.index(row, column);
      const bool on_box = column >= 20 && column < 30 && row >= 10 && row < 16;
      // The world's match in right0 lies at column - 4, the box there in 12 to 21.
      const bool behind_right0 = column - 4 >= 12 && column - 4 < 22 && row >= 10 && row < 16;
      const bool behind_left1 =
          column + 3 >= 15 && column + 3 < 25 && row - 2 >= 17 && row - 2 < 23;
      EXPECT_EQ(t.disparity_state[at] == MatchState::kHidden, !on_box && behind_right0);
      EXPECT_EQ(t.flow_state[at] == MatchState::kHidden, !on_box && behind_left1);
    }
  }
}

TEST(Occluders, LeaveTheImageAndCoverEachOther) {
  Triplet t = plain_triplet();
  Occluder leaving = dark_box();
  leaving.x = 1.5;  // columns 2 to 11: in right0 -6 to 3
  Occluder above = dark_box();
  above.x = 4.5;  // columns 5 to 14, but stands still in left1
  above.flow_u = above.flow_v = 0.0;
  leaving.flow_u = leaving.flow_v = 0.0;
  add_occluders({leaving, above}, t);
  EXPECT_EQ(t.disparity_state[t.index(12, 3)], MatchState::kOutside);
  EXPECT_EQ(t.disparity_state[t.index(12, 8)], MatchState::kVisible);
  EXPECT_EQ(t.flow_state[t.index(12, 3)], MatchState::kVisible);
  above.flow_u = -4.0;  // moves over the one below: columns 1 to 10
  t = plain_triplet();
  add_occluders({leaving, above}, t);
  EXPECT_EQ(t.flow_state[t.index(12, 3)], MatchState::kHidden);
  EXPECT_EQ(t.flow_u[t.index(12, 8)], -4.0F);
}

TEST(Occluders, CoverBorderPixelsByTheirArea) {
  Triplet t = plain_triplet();
  Occluder occluder = dark_box();
  occluder.x = 19.75;  // a quarter of column 19.5 to 20.5 is free
  add_occluders({occluder}, t);
  EXPECT_NEAR(t.left0[t.index(12, 20)], 25.0F, 1e-4F);
  EXPECT_NEAR(t.left0[t.index(12, 30)], 75.0F, 1e-4F);
}

TEST(Occluders, KeepTheTruthOfRealScenesExact) {
  for (std::uint64_t i = 0; i < 4; ++i) {
    Triplet t = quick_generator().make(i);
    Occluder big = dark_box();
    big.x = 120.2;
    big.y = 60.7;
    big.width = 130.0;
    big.height = 90.0;
    big.disparity = 33.3;
    big.flow_u = 25.6;
    add_occluders({big}, t);
    EXPECT_LT(quantile(stereo_residuals(t), 0.5), 1.0) << i;
    EXPECT_LT(quantile(flow_residuals(t), 0.5), 1.0) << i;
    EXPECT_LT(quantile(stereo_residuals(t), 0.9), 15.0) << i;
    EXPECT_LT(quantile(flow_residuals(t), 0.9), 15.0) << i;
  }
}

TEST(Occluders, MustHaveAPositiveDisparity) {
  Triplet t = plain_triplet();
  Occluder occluder = dark_box();
  occluder.disparity = 0.0;
  EXPECT_THROW(add_occluders({occluder}, t), ContractError);
}

}  // namespace
}  // namespace imslam::training
