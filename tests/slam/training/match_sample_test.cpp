#include "slam/training/match_sample.hpp"

#include <gtest/gtest.h>

#include "slam/base/error.hpp"
#include "tests/slam/training/samples.hpp"

namespace imslam::training {
namespace {

using nn::Index;

MatchSample sample(const QueryOptions& options, std::uint64_t index) {
  return draw_queries(quick_generator().make(index), options, Random(5));
}

TEST(MatchSample, PointsOnPixelsHaveTheTruthOfTheirPixels) {
  QueryOptions options;
  options.fractional_share = 0.0;
  const Triplet triplet = quick_generator().make(3);
  const MatchSample s = draw_queries(triplet, options, Random(5));
  for (Index i = 0; i < options.points; ++i) {
    const std::size_t at =
        triplet.index(static_cast<int>(s.points[2 * i + 1]), static_cast<int>(s.points[2 * i]));
    ASSERT_EQ(s.flow.displacement[2 * i], triplet.flow_u[at]);
    ASSERT_EQ(s.flow.displacement[2 * i + 1], triplet.flow_v[at]);
    ASSERT_EQ(s.stereo.displacement[i], -triplet.disparity[at]);
    ASSERT_EQ(s.flow.visible[i] == 1.0F, triplet.flow_state[at] == MatchState::kVisible);
    ASSERT_EQ(s.stereo.visible[i] == 1.0F, triplet.disparity_state[at] == MatchState::kVisible);
  }
}

// Truth between pixels is that of the images: what left0 shows there, left1 shows at the flow.
TEST(MatchSample, PointsBetweenPixelsMatchInTheImages) {
  QueryOptions options;
  options.fractional_share = 1.0;
  options.points = 2000;
  const Triplet triplet = quick_generator().make(4);
  const MatchSample s = draw_queries(triplet, options, Random(6));
  std::vector<double> residuals;
  for (Index i = 0; i < options.points; ++i) {
    if (s.flow.visible[i] == 0.0F) continue;
    const auto number = [](float value) { return static_cast<double>(value); };
    const double x = number(s.points[2 * i]);
    const double y = number(s.points[2 * i + 1]);
    residuals.push_back(
        std::abs(look(triplet, triplet.left0, x, y) -
                 look(triplet, triplet.left1, x + number(s.flow.displacement[2 * i]),
                      y + number(s.flow.displacement[2 * i + 1]))));
  }
  EXPECT_GT(residuals.size(), 1000U);
  EXPECT_LT(quantile(residuals, 0.5), 1.0);
}

TEST(MatchSample, TexturedPointsStandOnMoreContrast) {
  const auto mean_contrast = [](double textured_share) {
    QueryOptions options;
    options.textured_share = textured_share;
    options.fractional_share = 0.0;
    options.points = 1000;
    const Triplet triplet = quick_generator().make(2);
    const MatchSample s = draw_queries(triplet, options, Random(7));
    double sum = 0.0;
    for (Index i = 0; i < options.points; ++i) {
      const auto x = static_cast<int>(s.points[2 * i]);
      const auto y = static_cast<int>(s.points[2 * i + 1]);
      sum += std::abs(static_cast<double>(triplet.left0[triplet.index(y, x + 1)] -
                                          triplet.left0[triplet.index(y, x - 1)]));
    }
    return sum;
  };
  EXPECT_GT(mean_contrast(1.0), 1.3 * mean_contrast(0.0));
}

TEST(MatchSample, HintsAreNearTheMeanFlowAndOnlySometimesGiven) {
  QueryOptions options;
  options.hint_error = 0.0;
  options.hint_share = 1.0;
  const MatchSample told = sample(options, 1);
  double sum = 0.0;
  double count = 0.0;
  for (Index i = 0; i < options.points; ++i) {
    if (told.flow.visible[i] == 0.0F) continue;
    sum += static_cast<double>(told.flow.displacement[2 * i]);
    count += 1.0;
  }
  EXPECT_NEAR(told.predicted_x, sum / count, 1e-6);
  options.hint_share = 0.0;
  EXPECT_EQ(sample(options, 1).predicted_x, 0.0);
}

TEST(MatchSample, OptionsOutOfBoundsAreRefused) {
  QueryOptions options;
  options.points = 0;
  EXPECT_THROW(options.validate(), InputError);
  options = {};
  options.most_guess_error = 0.1;  // less than the least
  EXPECT_THROW(options.validate(), InputError);
}

}  // namespace
}  // namespace imslam::training
