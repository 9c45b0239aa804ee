#include "vo_net/match_network.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <set>
#include <string>

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
using nn::Index;
using nn::Mode;
using nn::Shape;
using nn::Tape;
using nn::Tensor;
using nn::Var;

Displacement shifted_a_bit(double, double) { return {3.0, -2.0}; }

/// A tiny network with random numbers everywhere.
template <typename S>
MatchNetwork<S> random_network() {
  Random random(11);
  MatchNetwork<S> network(tiny_match_network(), random);
  shake(parameters_of(network), random, 0.1);
  return network;
}

TEST(MatchNetwork, HasAboutEightHundredThousandParameters) {
  Random random(1);
  MatchNetwork<float> network({}, random);
  const Index count = parameters_of(network).number_count();
  EXPECT_GT(count, 780000);
  EXPECT_LT(count, 880000) << count;
  nn::ParameterList<float> encoder;
  network.encoder.collect(encoder, "");
  EXPECT_NEAR(static_cast<double>(encoder.number_count()), 269000.0, 3000.0);
}

TEST(MatchNetwork, OptionsAreSetByTheirKeys) {
  MatchNetworkOptions network;
  MatchLossOptions loss;
  Config config;
  config.section("network", network);
  config.section("loss", loss);
  config.set("network.normalisation.small_radius=9", "test");
  config.set("network.stereo_range_left=20", "test");
  config.set("loss.confident_error=0", "test");
  EXPECT_EQ(network.normalisation.small_radius, 9);
  EXPECT_EQ(network.coarse_window(MatchKind::kStereo).x_min, -20);
  EXPECT_NO_THROW(network.validate());
  EXPECT_THROW(loss.validate(), InputError);
}

TEST(MatchNetwork, ParametersHaveStableNames) {
  Random random(1);
  MatchNetwork<float> network(tiny_match_network(), random);
  std::set<std::string> names;
  for (const nn::Parameter<float>* parameter : parameters_of(network)) {
    names.insert(parameter->name);
  }
  for (const char* name :
       {"encoder.half_down.conv.weight", "encoder.eighth_dilated.norm.running_variance",
        "encoder.sixteenth_to_eighth.bias", "flow.coarse.sharpness",
        "flow.coarse.correction.weight", "stereo.fine4.sharpness", "stereo.head.output.bias"}) {
    EXPECT_EQ(names.count(name), 1U) << name;
  }
}

TEST(MatchNetwork, HasTheRightShapesForOddSizes) {
  MatchNetwork<float> network = random_network<float>();
  Random random(2);
  for (const Shape& size : {Shape{53, 70}, Shape{70, 53}, Shape{17, 16}, Shape{1, 1}}) {
    const TexturedPair pair(1, size[0], size[1], shifted_a_bit);
    for (const Index points : {Index{5}, Index{0}}) {
      Tape<float> tape(Mode::kInference);
      const FeaturePyramid f = network.encode(tape, tape.constant(nn::cast<float>(pair.images())));
      const auto cells = [&](Index stride, Index channels) {
        return Shape{2, (size[0] + stride - 1) / stride, (size[1] + stride - 1) / stride, channels};
      };
      EXPECT_EQ(tape.shape(f.half).text(), cells(2, 6).text());
      EXPECT_EQ(tape.shape(f.quarter).text(), cells(4, 8).text());
      EXPECT_EQ(tape.shape(f.eighth).text(), cells(8, 12).text());
      EXPECT_EQ(tape.shape(f.sixteenth).text(), cells(16, 12).text());
      const Tensor<double> at = random_points(random, points, size[0], size[1], 0.0);
      const NetworkMatch flow = match_pair(tape, network, pair, at, MatchKind::kFlow);
      const NetworkMatch stereo = match_pair(tape, network, pair, at, MatchKind::kStereo);
      EXPECT_EQ(tape.shape(flow.levels[0].logits).text(), Shape({1, points, 25}).text());
      EXPECT_EQ(tape.shape(stereo.levels[0].logits).text(), Shape({1, points, 12}).text());
      EXPECT_EQ(tape.shape(flow.levels[3].logits).text(), Shape({1, points, 49}).text());
      EXPECT_EQ(tape.shape(flow.prediction.displacement).text(), Shape({1, points, 2}).text());
      EXPECT_EQ(tape.shape(flow.prediction.log_sigma).text(), Shape({1, points, 2}).text());
      EXPECT_EQ(tape.shape(flow.prediction.correlation).text(), Shape({1, points, 1}).text());
      EXPECT_EQ(tape.shape(stereo.prediction.displacement).text(), Shape({1, points, 1}).text());
      EXPECT_EQ(tape.shape(stereo.prediction.log_sigma).text(), Shape({1, points, 1}).text());
      EXPECT_EQ(tape.shape(stereo.prediction.confidence).text(), Shape({1, points}).text());
      EXPECT_EQ(tape.shape(stereo.prediction.mixing).text(), Shape({1, points, 4}).text());
      EXPECT_TRUE(tape.array(flow.prediction.displacement).isFinite().all());
    }
  }
}

TEST(MatchNetwork, BlackAndFlatImagesGiveFiniteNumbers) {
  MatchNetwork<float> network = random_network<float>();
  Random random(2);
  const Tensor<double> points = random_points(random, 7, 53, 70, 0.0);
  for (const double gray : {0.0, 255.0}) {
    TexturedPair pair(1, 53, 70, shifted_a_bit);
    pair.image0.array() = gray;
    pair.image1.array() = gray;
    Tape<float> tape(Mode::kInference);
    const MatchPrediction p = match_pair(tape, network, pair, points, MatchKind::kFlow).prediction;
    for (const Var v : {p.displacement, p.log_sigma, p.correlation, p.confidence, p.mixing}) {
      EXPECT_TRUE(tape.array(v).isFinite().all());
    }
    EXPECT_GE(tape.array(p.log_sigma).minCoeff(), static_cast<float>(kLogSigmaFloor));
  }
}

TEST(MatchNetwork, StereoStaysOnTheRow) {
  MatchNetwork<float> network = random_network<float>();
  Random random(2);
  const TexturedPair pair(1, 53, 70, shifted_a_bit);
  const Tensor<double> points = random_points(random, 9, 53, 70, 0.0);
  Tape<float> tape(Mode::kInference);
  for (const LevelMatch& level :
       match_pair(tape, network, pair, points, MatchKind::kStereo).levels) {
    EXPECT_EQ(tape.matrix(level.displacement).col(1).cwiseAbs().maxCoeff(), 0.0F);
  }
}

TEST(MatchNetwork, UntrainedHeadMixesTheLevelsAndAddsNothing) {
  Random random(11);
  MatchNetwork<double> network(tiny_match_network(), random);
  const TexturedPair pair(1, 53, 70, shifted_a_bit);
  const Tensor<double> points = random_points(random, 9, 53, 70, 0.0);
  for (const MatchKind kind : {MatchKind::kFlow, MatchKind::kStereo}) {
    Tape<double> tape(Mode::kInference);
    const NetworkMatch match = match_pair(tape, network, pair, points, kind);
    const Index D = kind == MatchKind::kFlow ? 2 : 1;
    for (Index i = 0; i < 9; ++i) {
      const double* const mixing = tape.data(match.prediction.mixing) + 4 * i;
      EXPECT_NEAR(mixing[3] / mixing[2], std::exp(1.0), 1e-12);
      EXPECT_NEAR(mixing[0] + mixing[1] + mixing[2] + mixing[3], 1.0, 1e-12);
      for (Index d = 0; d < D; ++d) {
        double mixed = 0.0;
        for (std::size_t l = 0; l < 4; ++l) {
          mixed += mixing[l] * tape.data(match.levels[l].displacement)[2 * i + d];
        }
        EXPECT_NEAR(tape.data(match.prediction.displacement)[D * i + d], mixed, 1e-12);
      }
    }
  }
}

TEST(MatchNetwork, AHintedGuessPlacesTheFineWindows) {
  MatchNetwork<double> network = random_network<double>();
  Random random(2);
  const TexturedPair pair(1, 53, 70, shifted_a_bit);
  const Tensor<double> points = random_points(random, 9, 53, 70, 0.0);
  Tape<double> tape(Mode::kInference);
  Tensor<double> guess({1, 9, 2});
  for (Index i = 0; i < guess.size(); ++i) guess[i] = random.uniform(-40.0, 40.0);
  MatchHint hint;
  hint.guess = tape.constant(guess);
  const NetworkMatch match = match_pair(tape, network, pair, points, MatchKind::kFlow, hint);
  for (std::size_t l = 1; l < 4; ++l) {
    const double distance = (tape.array(match.levels[l].origin) - guess.array()).abs().maxCoeff();
    EXPECT_LE(distance, 0.5 * match.levels[l].stride);
  }
}

TEST(MatchNetwork, FoldedNormsGiveTheSameNumbers) {
  MatchNetwork<double> network = random_network<double>();
  Random random(3);
  for (nn::Parameter<double>* parameter : parameters_of(network)) {
    if (parameter->trainable || parameter->name.find("running") == std::string::npos) continue;
    for (Index i = 0; i < parameter->value.size(); ++i) {
      parameter->value[i] += random.uniform(0.0, 0.5);
    }
  }
  const TexturedPair pair(1, 53, 70, shifted_a_bit);
  const Tensor<double> points = random_points(random, 9, 53, 70, 0.0);
  for (const MatchKind kind : {MatchKind::kFlow, MatchKind::kStereo}) {
    MatchNetwork<double> folded = network;
    folded.fold();
    Tape<double> tape(Mode::kInference);
    // In double: in float rounding may choose another of two cells that are liked alike.
    const Var before = match_pair(tape, network, pair, points, kind).prediction.displacement;
    const Var after = match_pair(tape, folded, pair, points, kind).prediction.displacement;
    EXPECT_LT((tape.array(before) - tape.array(after)).abs().maxCoeff(), 1e-9);
    nn::ParameterList<double> list;
    EXPECT_THROW(folded.collect(list), ContractError);
  }
}

TEST(MatchNetwork, AnImageIsEncodedAloneAsInABatch) {
  MatchNetwork<float> network = random_network<float>();
  const TexturedPair pair(1, 53, 70, shifted_a_bit);
  Tape<float> tape(Mode::kInference);
  const FeaturePyramid both = network.encode(tape, tape.constant(nn::cast<float>(pair.images())));
  const FeaturePyramid alone = network.encode(tape, tape.constant(nn::cast<float>(pair.image1)));
  const FeaturePyramid second = sample_of(tape, both, 1);
  EXPECT_LT((tape.array(second.half) - tape.array(alone.half)).abs().maxCoeff(), 1e-5F);
  EXPECT_LT((tape.array(second.sixteenth) - tape.array(alone.sixteenth)).abs().maxCoeff(), 1e-5F);
}

TEST(MatchNetwork, FrozenNormsTrainOnTheNumbersOfInference) {
  MatchNetwork<float> network = random_network<float>();
  Random random(3);
  const TexturedPair pair(1, 53, 70, shifted_a_bit);
  const Tensor<double> points = random_points(random, 9, 53, 70, 0.0);
  for (const MatchKind kind : {MatchKind::kFlow, MatchKind::kStereo}) {
    Tape<float> inference(Mode::kInference);
    Tape<float> training;
    const auto displacement = [&](Tape<float>& tape) {
      return tape.copy(match_pair(tape, network, pair, points, kind).prediction.displacement);
    };
    network.freeze_norms(false);
    const Tensor<float> expected = displacement(inference);
    EXPECT_GT((displacement(training).array() - expected.array()).abs().maxCoeff(), 1e-3F);
    network.freeze_norms(true);
    EXPECT_EQ((displacement(training).array() - expected.array()).abs().maxCoeff(), 0.0F);
  }
}

TEST(MatchNetwork, FloatAgreesWithDouble) {
  MatchNetwork<double> exact = random_network<double>();
  MatchNetwork<float> fast = random_network<float>();
  nn::copy_values(parameters_of(exact), parameters_of(fast));
  Random random(3);
  const TexturedPair pair(1, 53, 70, shifted_a_bit);
  const Tensor<double> points = random_points(random, 9, 53, 70, 0.0);
  Tape<double> slow_tape(Mode::kInference);
  Tape<float> tape(Mode::kInference);
  const Var expected =
      match_pair(slow_tape, exact, pair, points, MatchKind::kFlow).prediction.displacement;
  const Var actual = match_pair(tape, fast, pair, points, MatchKind::kFlow).prediction.displacement;
  for (Index i = 0; i < 18; ++i) {
    EXPECT_NEAR(static_cast<double>(tape.data(actual)[i]), slow_tape.data(expected)[i], 1e-3);
  }
}

TEST(MatchNetwork, RefusesWrongShapesAndSizes) {
  MatchNetwork<float> network = random_network<float>();
  Tape<float> tape;
  EXPECT_THROW(network.encode(tape, tape.constant(Tensor<float>({1, 20, 20, 3}))), ContractError);
  const FeaturePyramid a = network.encode(tape, tape.constant(Tensor<float>({1, 40, 40, 1})));
  const FeaturePyramid b = network.encode(tape, tape.constant(Tensor<float>({1, 40, 60, 1})));
  const Var points = tape.constant(Tensor<float>({1, 4, 2}));
  EXPECT_THROW(network.forward(tape, a, b, points, MatchKind::kFlow), ContractError);
  EXPECT_THROW(network.forward(tape, a, a, tape.constant(Tensor<float>({4, 2})), MatchKind::kFlow),
               ContractError);
  MatchHint hint;
  hint.predicted_x = std::numeric_limits<double>::quiet_NaN();
  EXPECT_THROW(network.forward(tape, a, a, points, MatchKind::kFlow, hint), ContractError);
  MatchNetworkOptions options;
  options.fine_radius = 0;
  Random random(1);
  EXPECT_THROW(MatchNetwork<float>(options, random), InputError);
}

}  // namespace
}  // namespace imslam::vo
