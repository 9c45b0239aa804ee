#include "slam/adaptation/loss_agreement.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "slam/base/error.hpp"
#include "tests/support/temp_dir.hpp"

namespace imslam::adaptation {
namespace {

using imslam::testing::TempDir;

constexpr double kNone = std::numeric_limits<double>::quiet_NaN();

LearningLog log_of(std::vector<double> losses, std::vector<double> errors) {
  LearningLog log;
  for (std::size_t i = 0; i < losses.size(); ++i) log.epoch.push_back(static_cast<double>(i));
  log.curves["held_out_loss"] = std::move(losses);
  log.curves["graph_ate_m"] = std::move(errors);
  return log;
}

TEST(RankCorrelation, IsOneForEqualRankingsAndMinusOneForOppositeOnes) {
  EXPECT_DOUBLE_EQ(*rank_correlation({1, 2, 3, 4}, {1, 8, 27, 64}), 1.0);
  EXPECT_DOUBLE_EQ(*rank_correlation({1, 2, 3, 4}, {4, 3, 2, 1}), -1.0);
}

TEST(RankCorrelation, GivesTiesTheirMeanRank) {
  // Ranks 1 2.5 2.5 4 against 1 2 3 4: 4.5 / sqrt(4.5 * 5).
  EXPECT_NEAR(*rank_correlation({1, 2, 2, 3}, {1, 2, 3, 4}), 4.5 / std::sqrt(22.5), 1e-12);
}

TEST(RankCorrelation, IsUndefinedWithoutChangeOrWithTwoPairs) {
  EXPECT_FALSE(rank_correlation({1, 1, 1}, {1, 2, 3}));
  EXPECT_FALSE(rank_correlation({1, 2}, {1, 2}));
}

TEST(LossAgreement, SaysWhetherTheyAgreeContradictOrNobodyKnows) {
  using Verdict = LossAgreement::Verdict;
  const std::vector<double> falling = {6, 5, 4, 3, 2, 1};
  EXPECT_EQ(loss_agreement(log_of(falling, falling)).at(0).verdict, Verdict::kAgree);
  const auto rising = loss_agreement(log_of(falling, {1, 2, 3, 4, 5, 6})).at(0);
  EXPECT_EQ(rising.verdict, Verdict::kContradict);
  EXPECT_NE(rising.sentence().find("not aligned"), std::string::npos);
  EXPECT_EQ(loss_agreement(log_of(falling, {3, 1, 2, 3, 1, 2})).at(0).verdict, Verdict::kUnclear);
  EXPECT_EQ(loss_agreement(log_of({3, 2, 1}, {3, 2, 1})).at(0).verdict, Verdict::kUnclear);
}

TEST(LossAgreement, TellsTheChosenEpochFromTheBest) {
  const auto found = loss_agreement(log_of({5, 4, 1, 3, 2}, {1.0, kNone, 0.9, 0.5, 0.8})).at(0);
  EXPECT_EQ(found.looks, 4U);
  EXPECT_EQ(found.chosen_epoch, 2.0);
  EXPECT_EQ(found.best_epoch, 3.0);
  EXPECT_EQ(found.best_error, 0.5);
}

TEST(LearningLog, ReadsColumnsByNameAndLeavesGaps) {
  const TempDir dir;
  const auto file = dir.write("log.csv",
                              "step,samples,loss,learned_loss,vo_ate_m,rate\n0,0,-8,-7,,0\n"
                              "2,6,-9,-8,0.25,1\n4,12,1e300,1e300,,1\n");
  const LearningLog log = read_learning_log(file, 2);
  EXPECT_EQ(log.epoch, (std::vector<double>{0, 1, 2}));
  EXPECT_EQ(log.curves.at("held_out_loss")[1], -9.0);
  EXPECT_TRUE(std::isnan(log.curves.at("held_out_loss")[2]));
  EXPECT_EQ(log.curves.at("learned_loss")[0], -7.0);
  EXPECT_TRUE(std::isnan(log.curves.at("vo_ate_m")[0]));
  EXPECT_EQ(log.curves.at("vo_ate_m")[1], 0.25);
}

TEST(LearningLog, NamesTheLineThatIsBroken) {
  const TempDir dir;
  const auto file = dir.write("log.csv", "step,samples,loss\n0,0,1\n2,1\n");
  try {
    read_learning_log(file, 1);
    FAIL();
  } catch (const InputError& error) {
    EXPECT_NE(std::string(error.what()).find("log.csv:3:"), std::string::npos) << error.what();
  }
}

}  // namespace
}  // namespace imslam::adaptation
