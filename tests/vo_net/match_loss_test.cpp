#include "vo_net/match_loss.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "slam/nn/ops/arithmetic.hpp"
#include "tests/vo_net/match_fixture.hpp"

namespace imslam::vo {
namespace {

using imslam::testing::Displacement;
using imslam::testing::match_pair;
using imslam::testing::parameters_of;
using imslam::testing::random_points;
using imslam::testing::shake;
using imslam::testing::TexturedPair;
using imslam::testing::tiny_match_network;
using imslam::testing::truth_at;
using nn::Index;
using nn::Tape;
using nn::Tensor;
using nn::Var;

constexpr Index kHeight = 40;
constexpr Index kWidth = 48;

/// Flow and stereo losses of two small pairs together: every parameter has a say.
struct Task {
  TexturedPair flow_pair{1, kHeight, kWidth, [](double x, double) {
                           return Displacement{2.3 + 0.02 * x, -3.1};
                         }};
  TexturedPair stereo_pair{2, kHeight, kWidth, [](double, double y) {
                             return Displacement{-4.2 - 0.03 * y, 0.0};
                           }};
  Tensor<double> points;

  Task() {
    Random random(4);
    points = random_points(random, 6, kHeight, kWidth, 8.0);
  }

  Var loss(Tape<double>& tape, MatchNetwork<double>& network) const {
    return add(tape, loss_of(tape, network, flow_pair, MatchKind::kFlow),
               loss_of(tape, network, stereo_pair, MatchKind::kStereo));
  }

 private:
  Var loss_of(Tape<double>& tape,
              MatchNetwork<double>& network,
              const TexturedPair& pair,
              MatchKind kind) const {
    MatchTruth<double> truth = truth_at(pair, points, kind);
    truth.visible[1] = 0.0;
    truth.valid[2] = 0.0;
    MatchHint hint;  // near the truth, so that it lies in all windows
    Tensor<double> near(points.shape());
    for (Index i = 0; i < points.shape()[1]; ++i) {
      const Displacement d = pair.d(points[2 * i], points[2 * i + 1]);
      near[2 * i] = d.x + 0.4;
      near[2 * i + 1] = d.y - 0.3;
    }
    hint.guess = tape.constant(near);
    return match_loss(tape, match_pair(tape, network, pair, points, kind, hint), truth).total;
  }
};

// One direction per parameter, with all of its numbers in it.
TEST(MatchLoss, GradientsOfAllParametersMatchCentralDifferences) {
  Random random(6);
  MatchNetwork<double> network(tiny_match_network(), random);
  const nn::ParameterList<double> parameters = parameters_of(network);
  shake(parameters, random, 0.05);
  const Task task;
  Tape<double> tape;
  tape.backward(task.loss(tape, network));
  nn::Gradients<double> gradients = nn::zero_gradients(parameters);
  tape.add_gradients_to(parameters, gradients);

  constexpr double kStep = 1e-6;
  for (std::size_t k = 0; k < parameters.count(); ++k) {
    nn::Parameter<double>& parameter = parameters[k];
    if (!parameter.trainable) continue;
    const Tensor<double> start = parameter.value.clone();
    Tensor<double> direction(start.shape());
    for (Index i = 0; i < direction.size(); ++i) direction[i] = random.uniform(-1.0, 1.0);
    const auto loss_at = [&](double step) {
      parameter.value.array() = start.array() + step * direction.array();
      Tape<double> fresh;
      return fresh.number(task.loss(fresh, network));
    };
    const double numeric = (loss_at(kStep) - loss_at(-kStep)) / (2.0 * kStep);
    parameter.value.array() = start.array();
    const double exact = (gradients[k].array() * direction.array()).sum();
    EXPECT_NEAR(exact, numeric, 1e-6 * std::max(1.0, std::abs(numeric))) << parameter.name;
    EXPECT_GT(gradients[k].array().abs().maxCoeff(), 0.0) << parameter.name;
  }
}

/// A match of one point whose logits and predictions are given by hand.
struct HandMade {
  Tape<double> tape;
  NetworkMatch match;

  explicit HandMade(Index dimensions) {
    for (LevelMatch& level : match.levels) {
      level.stride = 4;
      level.window = nn::Window::square(1);
      level.logits = tape.constant(Tensor<double>({1, 2, 9}));
      level.origin = tape.constant(Tensor<double>({1, 2, 2}));
      level.displacement = tape.constant(Tensor<double>({1, 2, 2}));
    }
    match.prediction.displacement = tape.input(Tensor<double>({1, 2, dimensions}));
    match.prediction.log_sigma = tape.constant(Tensor<double>({1, 2, dimensions}));
    match.prediction.confidence = tape.constant(Tensor<double>({1, 2}));
    if (dimensions == 2) {
      match.prediction.correlation = tape.constant(Tensor<double>({1, 2, 1}, {0.6, 0.0}));
    }
  }
};

MatchTruth<double> truth_of(Index dimensions) {
  MatchTruth<double> truth{Tensor<double>({1, 2, dimensions}), Tensor<double>({1, 2}),
                           Tensor<double>({1, 2})};
  truth.valid.array() = 1.0;
  truth.visible.array() = 1.0;
  return truth;
}

TEST(MatchLoss, CrossEntropyAsksForTheCellsAroundTheTruth) {
  HandMade hand(2);
  MatchTruth<double> truth = truth_of(2);
  truth.displacement[0] = 3.0;  // three quarters of the way to the next cell
  truth.visible[1] = 0.0;
  double* const logits = hand.tape.data(hand.match.levels[2].logits);
  const double wanted[] = {std::log(0.25), std::log(0.75)};
  for (int k = 0; k < 9; ++k) logits[k] = -100.0;
  logits[4] = wanted[0];
  logits[5] = wanted[1];
  const MatchLoss loss = match_loss(hand.tape, hand.match, truth);
  const double entropy = -0.25 * wanted[0] - 0.75 * wanted[1];
  EXPECT_NEAR(hand.tape.number(loss.cross_entropy[2]), entropy, 1e-12);  // cannot be less
  EXPECT_NEAR(hand.tape.number(loss.cross_entropy[1]), std::log(9.0), 1e-12);
}

TEST(MatchLoss, CrossEntropyLeavesOutWhatLiesBeyondTheWindow) {
  HandMade hand(2);
  MatchTruth<double> truth = truth_of(2);
  truth.displacement[0] = 4.0;  // the last cell, no neighbour needed
  truth.displacement[2] = 4.1;
  hand.tape.data(hand.match.levels[0].logits)[9] = 50.0;
  const MatchLoss loss = match_loss(hand.tape, hand.match, truth);
  EXPECT_NEAR(hand.tape.number(loss.cross_entropy[0]), std::log(9.0), 1e-12);
}

TEST(MatchLoss, LikelihoodIsThatOfTheDocumentedScaleMatrix) {
  HandMade hand(2);
  const MatchTruth<double> truth = truth_of(2);
  const double rx = 1.5;
  const double ry = -0.7;
  const double sx = std::exp(0.3);
  const double sy = std::exp(-0.2);
  hand.tape.data(hand.match.prediction.displacement)[0] = rx;
  hand.tape.data(hand.match.prediction.displacement)[1] = ry;
  hand.tape.data(hand.match.prediction.log_sigma)[0] = 0.3;
  hand.tape.data(hand.match.prediction.log_sigma)[1] = -0.2;
  MatchTruth<double> first_only = truth;
  first_only.visible[1] = 0.0;
  const double rho = 0.6;
  const double determinant = sx * sx * sy * sy * (1.0 - rho * rho);
  const double distance =
      (rx * rx * sy * sy - 2.0 * rho * sx * sy * rx * ry + ry * ry * sx * sx) / determinant;
  const double constant = std::log(2.0 * 3.14159265358979323846);  // 2-D t: 1 / (2 pi |S|^1/2)
  const double expected = constant + 0.5 * std::log(determinant) + 2.5 * std::log1p(distance / 3.0);
  const MatchLoss loss = match_loss(hand.tape, hand.match, first_only);
  EXPECT_NEAR(hand.tape.number(loss.likelihood), expected, 1e-12);
}

TEST(MatchLoss, ConfidenceMeansVisibleAndNear) {
  for (const Index dimensions : {Index{1}, Index{2}}) {
    const auto confidence_loss = [&](double error, double visible, double logit) {
      HandMade hand(dimensions);
      MatchTruth<double> truth = truth_of(dimensions);
      truth.valid[1] = 0.0;
      truth.visible[0] = visible;
      hand.tape.data(hand.match.prediction.displacement)[0] = error;
      hand.tape.data(hand.match.prediction.confidence)[0] = logit;
      return hand.tape.number(match_loss(hand.tape, hand.match, truth).confidence);
    };
    EXPECT_LT(confidence_loss(1.9, 1.0, 9.0), 1e-3);
    EXPECT_LT(confidence_loss(2.1, 1.0, -9.0), 1e-3);
    EXPECT_LT(confidence_loss(0.0, 0.0, -9.0), 1e-3);
    EXPECT_GT(confidence_loss(0.0, 0.0, 9.0), 8.0);
  }
}

TEST(MatchLoss, PointsWithoutTruthCountForNothing) {
  const double nan = std::numeric_limits<double>::quiet_NaN();
  for (const Index dimensions : {Index{1}, Index{2}}) {
    HandMade one(dimensions);
    MatchTruth<double> truth = truth_of(dimensions);
    truth.displacement[0] = 1.0;
    truth.displacement[dimensions] = nan;
    truth.valid[1] = 0.0;
    const Var total = match_loss(one.tape, one.match, truth).total;
    const double expected = one.tape.number(total);
    EXPECT_TRUE(std::isfinite(expected));
    one.tape.backward(total);
    const double* const gradient = one.tape.gradient_data(one.match.prediction.displacement);
    EXPECT_NE(gradient[0], 0.0);
    EXPECT_EQ(gradient[dimensions], 0.0);
    HandMade other(dimensions);
    other.tape.data(other.match.prediction.displacement)[dimensions] = 77.0;
    other.tape.data(other.match.prediction.confidence)[1] = 5.0;
    other.tape.data(other.match.levels[1].logits)[9 + 3] = 5.0;
    EXPECT_EQ(other.tape.number(match_loss(other.tape, other.match, truth).total), expected);

    HandMade none(dimensions);
    truth.valid.array() = 0.0;
    EXPECT_EQ(none.tape.number(match_loss(none.tape, none.match, truth).total), 0.0);
  }
}

}  // namespace
}  // namespace imslam::vo
