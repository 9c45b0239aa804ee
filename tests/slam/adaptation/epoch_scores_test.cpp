#include "slam/adaptation/epoch_scores.hpp"

#include <gtest/gtest.h>

#include <cmath>

namespace imslam::adaptation {
namespace {

EpochScores scores(double loss) {
  EpochScores one;
  one.held_out_loss = loss;
  one.learned_loss = 2.0 * loss;
  return one;
}

TEST(EpochScores, TheMeanIsOverTheSequencesAndEachFigureOverThoseThatHaveIt) {
  EpochScores known = scores(3.0);
  known.graph_ate_m = 0.5;
  const EpochScores mean = mean_of({scores(1.0), known});
  EXPECT_DOUBLE_EQ(mean.held_out_loss, 2.0);
  EXPECT_DOUBLE_EQ(mean.learned_loss, 4.0);
  EXPECT_EQ(mean.graph_ate_m, 0.5);
  EXPECT_FALSE(mean.vo_ate_m.has_value());
}

// A graph that did not converge has a loss of 1e300, of which no gain elsewhere could be seen.
TEST(EpochScores, BesideAnUnusableSequenceTheOthersStillCount) {
  const EpochScores worse = mean_of({scores(1.0), scores(1e300)});
  const EpochScores better = mean_of({scores(0.9), scores(1e300)});
  EXPECT_TRUE(std::isfinite(worse.held_out_loss) && std::isfinite(worse.learned_loss));
  EXPECT_NEAR(worse.held_out_loss - better.held_out_loss, 0.05, 1e-6);
  EXPECT_NEAR(worse.learned_loss - better.learned_loss, 0.1, 1e-6);
  EXPECT_GT(better.held_out_loss, mean_of({scores(1e3), scores(1e3)}).held_out_loss);
}

TEST(EpochScores, ArePackedBitByBit) {
  EpochScores one = scores(0.1);
  one.imu_position_m = 1.0 / 3.0;
  const EpochScores back = EpochScores::unpacked(one.packed());
  EXPECT_EQ(back.held_out_loss, one.held_out_loss);
  EXPECT_EQ(back.imu_position_m, one.imu_position_m);
  EXPECT_FALSE(back.graph_rpe_deg.has_value());
}

}  // namespace
}  // namespace imslam::adaptation
