#include "slam/system/stage_timer.hpp"

#include <gtest/gtest.h>

namespace imslam::system {
namespace {

TEST(StageTimer, SummarisesByNearestRank) {
  StageTimer timer;
  for (int i = 1; i <= 101; ++i) timer.add("vo", static_cast<double>(i));
  const auto summary = timer.summaries().at("vo");
  EXPECT_EQ(summary.count, 101U);
  EXPECT_DOUBLE_EQ(summary.mean_ms, 51.0);
  EXPECT_DOUBLE_EQ(summary.p50_ms, 51.0);
  EXPECT_DOUBLE_EQ(summary.p99_ms, 100.0);
  EXPECT_DOUBLE_EQ(summary.max_ms, 101.0);
  EXPECT_NEAR(summary.total_s, 5.151, 1e-9);
}

TEST(StageTimer, AScopeAddsOneValue) {
  StageTimer timer;
  { const StageScope scope(timer, "graph"); }
  ASSERT_EQ(timer.values_ms("graph").size(), 1U);
  EXPECT_GE(timer.values_ms("graph").front(), 0.0F);
  EXPECT_TRUE(timer.values_ms("unknown").empty());
}

}  // namespace
}  // namespace imslam::system
