#include "vo_net/fine_matcher.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "slam/base/random.hpp"
#include "slam/nn/ops/normalise.hpp"

namespace imslam::vo {
namespace {

using nn::Index;
using nn::Tape;
using nn::Tensor;
using nn::Var;

constexpr Index kRows = 12;
constexpr Index kColumns = 15;
constexpr Index kChannels = 32;
constexpr int kStride = 4;

Tensor<double> random_features(Random& random, Index height, Index width) {
  Tensor<double> features({1, height, width, kChannels});
  for (Index i = 0; i < features.size(); ++i) features[i] = random.normal();
  return features;
}

TEST(FineMatcher, WindowStandsOnTheCellNearestToTheGuess) {
  Random random(3);
  Tape<double> tape;
  const Var f0 = l2_normalise(tape, tape.constant(random_features(random, kRows, kColumns)));
  const Var f1 = l2_normalise(tape, tape.constant(random_features(random, kRows, kColumns)));
  constexpr Index kPoints = 20;
  Tensor<double> points({1, kPoints, 2});
  Tensor<double> guess({1, kPoints, 2});
  for (Index i = 0; i < 2 * kPoints; ++i) {
    points[i] = random.uniform(0.0, 44.0);
    guess[i] = random.uniform(-9.0, 9.0);
  }
  const FineMatcher<double> matcher({}, kStride);
  const auto match = matcher.forward(tape, f0, f1, tape.constant(points), tape.constant(guess));
  for (Index i = 0; i < kPoints; ++i) {
    const double* const origin = tape.data(match.level.origin) + 2 * i;
    const double x = (points[2 * i] + origin[0]) / kStride;
    const double y = (points[2 * i + 1] + origin[1]) / kStride;
    ASSERT_NEAR(x, std::round(x), 1e-12);
    ASSERT_NEAR(y, std::round(y), 1e-12);
    ASSERT_LE(std::abs(origin[0] - guess[2 * i]), 0.5 * kStride);
    ASSERT_LE(std::abs(origin[1] - guess[2 * i + 1]), 0.5 * kStride);
    for (int k = 0; k < matcher.window.count(); ++k) {
      const Index column = std::lround(x) + matcher.window.x(k);
      const Index row = std::lround(y) + matcher.window.y(k);
      double cosine = 0.0;
      if (column >= 0 && column < kColumns && row >= 0 && row < kRows) {
        const double* const cell = tape.data(f1) + (row * kColumns + column) * kChannels;
        for (Index c = 0; c < kChannels; ++c) {
          cosine += tape.data(match.query)[i * kChannels + c] * cell[c];
        }
      }
      ASSERT_NEAR(tape.data(match.cosines)[i * matcher.window.count() + k], cosine, 1e-12);
    }
  }
}

TEST(FineMatcher, FindsTheSamePlaceFromAnyGuessInReach) {
  Random random(4);
  Tape<double> tape;
  const Var f = l2_normalise(tape, tape.constant(random_features(random, kRows, kColumns)));
  FineMatcher<double> matcher({}, kStride);
  matcher.sharpness.value[0] = std::log(200.0);  // only the best counts
  const Var points = tape.constant(Tensor<double>({1, 1, 2}, {24.0, 20.0}));
  for (int trial = 0; trial < 30; ++trial) {
    const Tensor<double> guess({1, 1, 2},
                               {random.uniform(-13.0, 13.0), random.uniform(-13.0, 13.0)});
    const auto match = matcher.forward(tape, f, f, points, tape.constant(guess));
    EXPECT_NEAR(tape.data(match.level.displacement)[0], 0.0, 1e-9);
    EXPECT_NEAR(tape.data(match.level.displacement)[1], 0.0, 1e-9);
  }
}

}  // namespace
}  // namespace imslam::vo
