#include <gtest/gtest.h>

#include "tests/vo_net/match_fixture.hpp"

namespace imslam::vo {
namespace {

using imslam::testing::parameters_of;
using imslam::testing::shake;
using imslam::testing::tiny_match_network;
using nn::Index;
using nn::Mode;
using nn::Shape;
using nn::Tape;
using nn::Tensor;

MatchNetwork<float> random_network() {
  Random random(11);
  MatchNetwork<float> network(tiny_match_network(), random);
  shake(parameters_of(network), random, 0.1);
  return network;
}

/// A pair in the middle of large images, far from any border for all that the network sees.
struct Scene {
  static constexpr Index kSize = 512;
  Tensor<float> image0{Shape{1, kSize, kSize, 1}};
  Tensor<float> image1{Shape{1, kSize, kSize, 1}};
  Tensor<float> points{Shape{1, 3, 2}, {250.3F, 247.0F, 262.5F, 260.2F, 244.1F, 255.9F}};

  Scene(Index move0_x, Index move0_y, Index move1_x, Index move1_y) {
    Random random(9);
    const imslam::testing::SplineTexture texture(random, 6.0);
    for (Index i = 0, at = 0; i < kSize; ++i) {
      for (Index j = 0; j < kSize; ++j, ++at) {
        const auto gray = [&](Index x, Index y) {
          return static_cast<float>(texture.at(static_cast<double>(x), static_cast<double>(y)));
        };
        image0[at] = gray(j - move0_x + 5, i - move0_y - 3);
        image1[at] = gray(j - move1_x, i - move1_y);
      }
    }
    for (Index p = 0; p < 3; ++p) {
      points[2 * p] += static_cast<float>(move0_x);
      points[2 * p + 1] += static_cast<float>(move0_y);
    }
  }
};

struct Answer {
  Tensor<float> coarse;
  Tensor<float> displacement;
  Tensor<float> log_sigma;
};

Answer answer_for(MatchNetwork<float>& network, const Scene& scene, const MatchHint& hint = {}) {
  Tape<float> tape(Mode::kInference);
  const FeaturePyramid f0 = network.encode(tape, tape.constant(scene.image0));
  const FeaturePyramid f1 = network.encode(tape, tape.constant(scene.image1));
  const NetworkMatch match =
      network.forward(tape, f0, f1, tape.constant(scene.points), MatchKind::kFlow, hint);
  return {tape.copy(match.levels[0].displacement), tape.copy(match.prediction.displacement),
          tape.copy(match.prediction.log_sigma)};
}

void expect_moved(
    const Tensor<float>& actual, const Tensor<float>& before, float x, float y, const char* what) {
  for (Index i = 0; i < actual.size(); i += 2) {
    EXPECT_NEAR(actual[i], before[i] + x, 2e-3) << what << " x of point " << i / 2;
    EXPECT_NEAR(actual[i + 1], before[i + 1] + y, 2e-3) << what << " y of point " << i / 2;
  }
}

TEST(MatchEquivariance, AnswersTheSameWhenBothImagesMoveByWholeCells) {
  MatchNetwork<float> network = random_network();
  const Answer here = answer_for(network, Scene(0, 0, 0, 0));
  const Answer there = answer_for(network, Scene(32, -16, 32, -16));
  expect_moved(there.coarse, here.coarse, 0.0F, 0.0F, "coarse");
  expect_moved(there.displacement, here.displacement, 0.0F, 0.0F, "displacement");
  expect_moved(there.log_sigma, here.log_sigma, 0.0F, 0.0F, "log sigma");
}

TEST(MatchEquivariance, TheAnswerMovesWithThePredictionAndTheSecondImage) {
  MatchNetwork<float> network = random_network();
  const Answer here = answer_for(network, Scene(0, 0, 0, 0));
  MatchHint hint;
  hint.predicted_x = 35.0;  // rounded to two cells
  hint.predicted_y = -14.0;
  const Answer moved = answer_for(network, Scene(0, 0, 32, -16), hint);
  expect_moved(moved.coarse, here.coarse, 32.0F, -16.0F, "coarse");
  expect_moved(moved.displacement, here.displacement, 32.0F, -16.0F, "displacement");
  expect_moved(moved.log_sigma, here.log_sigma, 0.0F, 0.0F, "log sigma");
}

}  // namespace
}  // namespace imslam::vo
