#include "tools/bench/matching/quality.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "tools/bench/matching/summary.hpp"

namespace imslam::bench {
namespace {

PointResult result(double error, double score, bool accepted) {
  PointResult r;
  r.answered = true;
  r.accepted = accepted;
  r.score = score;
  r.error = error;
  r.normalised_error = r.confidence = NAN;
  return r;
}

std::vector<PointResult> five_results() {
  PointResult none;
  none.normalised_error = none.confidence = NAN;
  return {result(0.1, 0.9, true), result(8.0, 0.2, true), result(0.3, 0.8, true),
          result(4.0, 0.1, false), none};
}

TEST(Quality, CountsWhatTheMethodStandsBy) {
  const Quality q = natural_quality(five_results());
  EXPECT_EQ(q.points, 3U);
  EXPECT_DOUBLE_EQ(q.coverage, 0.6);
  EXPECT_DOUBLE_EQ(q.median, 0.3);
  EXPECT_NEAR(q.mean, 2.8, 1e-12);
  EXPECT_NEAR(q.gross, 1.0 / 3.0, 1e-12);
}

TEST(Quality, AtACoverageTheBestScoredPointsCount) {
  const Quality q = quality_at(0.4, five_results());
  EXPECT_EQ(q.points, 2U);
  EXPECT_DOUBLE_EQ(q.median, 0.3);  // the upper one of two
  EXPECT_DOUBLE_EQ(q.gross, 0.0);
}

TEST(Quality, AnswersThatTheMethodDoesNotStandByCountAtGreaterCoverage) {
  const Quality q = quality_at(1.0, five_results());
  EXPECT_EQ(q.points, 4U);
  EXPECT_DOUBLE_EQ(q.coverage, 0.8);
  EXPECT_DOUBLE_EQ(q.gross, 0.5);
}

TEST(Quality, OfNothingIsNotANumber) {
  EXPECT_TRUE(std::isnan(natural_quality({}).median));
  EXPECT_TRUE(std::isnan(natural_quality({}).mean));
}

TEST(Calibration, ComparesWhatIsStatedWithWhatIsTrue) {
  std::vector<PointResult> results = five_results();
  EXPECT_FALSE(calibration_of(results).has_value());
  for (std::size_t i = 0; i < 4; ++i) {
    results[i].confidence = 0.25 * static_cast<double>(i + 1);
    results[i].normalised_error = static_cast<double>(i);
  }
  const auto calibration = calibration_of(results);
  ASSERT_TRUE(calibration.has_value());
  EXPECT_DOUBLE_EQ(calibration->stated, 0.625);
  EXPECT_DOUBLE_EQ(calibration->right, 0.5);
  EXPECT_DOUBLE_EQ(calibration->normalised_median, 1.0);  // of 0, 1, 2: the fourth is not accepted
}

}  // namespace
}  // namespace imslam::bench
