#include "slam/report/thinning.hpp"

#include <gtest/gtest.h>

#include <cmath>

namespace imslam::report {
namespace {

TEST(Thinning, SpreadKeepsBothEndsAndTheOrder) {
  for (const std::size_t count : {0U, 1U, 2U, 9U, 10U, 11U, 1000U, 12345U}) {
    const std::vector<std::size_t> indices = spread(count, 10);
    EXPECT_EQ(indices.size(), std::min<std::size_t>(count, 10));
    if (count == 0) continue;
    EXPECT_EQ(indices.front(), 0U);
    EXPECT_EQ(indices.back(), count - 1);
    for (std::size_t i = 1; i < indices.size(); ++i) EXPECT_LT(indices[i - 1], indices[i]);
  }
}

TEST(Thinning, KeepsPeaksOfEitherSign) {
  std::vector<double> values(1000, 0.5);
  values[137] = -7.0;
  values[801] = 9.0;
  const std::vector<float> thinned = thin(values, 50, Extreme::kLargestMagnitude);
  ASSERT_EQ(thinned.size(), 50U);
  EXPECT_FLOAT_EQ(*std::min_element(thinned.begin(), thinned.end()), -7.0F);
  EXPECT_FLOAT_EQ(*std::max_element(thinned.begin(), thinned.end()), 9.0F);
  EXPECT_FLOAT_EQ(thin(values, 50, Extreme::kSmallest)[40], 0.5F);
}

TEST(Thinning, GapRemainsOnlyWhereNothingIsKnown) {
  const double gap = std::nan("");
  const std::vector<float> thinned = thin({gap, 3.0, gap, gap}, 2, Extreme::kLargestMagnitude);
  EXPECT_FLOAT_EQ(thinned[0], 3.0F);
  EXPECT_TRUE(std::isnan(thinned[1]));
}

TEST(Thinning, BoxSummaryMatchesNumpy) {
  // numpy.percentile([1 2 3 4 5 6 7 8 40], [25 50 75]) = 3 5 7; whiskers within 1.5 * 4
  const BoxSummary box = box_summary({5, 40, 1, 2, 4, 3, 8, 7, 6});
  EXPECT_DOUBLE_EQ(box.q1, 3.0);
  EXPECT_DOUBLE_EQ(box.median, 5.0);
  EXPECT_DOUBLE_EQ(box.q3, 7.0);
  EXPECT_DOUBLE_EQ(box.low, 1.0);
  EXPECT_DOUBLE_EQ(box.high, 8.0);
  EXPECT_DOUBLE_EQ(box.max, 40.0);
  EXPECT_DOUBLE_EQ(box.rmse, std::sqrt(1804.0 / 9.0));
}

TEST(Thinning, WhiskersNeverLieInsideTheBox) {
  const BoxSummary box = box_summary({0, 0, 0, 100});
  EXPECT_LE(box.low, box.q1);
  EXPECT_GE(box.high, box.q3);
  const BoxSummary one = box_summary({2.5});
  EXPECT_DOUBLE_EQ(one.low, 2.5);
  EXPECT_DOUBLE_EQ(one.high, 2.5);
}

}  // namespace
}  // namespace imslam::report
