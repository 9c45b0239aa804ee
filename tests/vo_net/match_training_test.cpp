#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "slam/base/parallel.hpp"
#include "tests/vo_net/match_training.hpp"

namespace imslam::vo {
namespace {

using imslam::testing::Displacement;
using imslam::testing::match_pair;
using imslam::testing::parameters_of;
using imslam::testing::tiny_match_network;
using Sample = imslam::testing::MatchSample;
using nn::Index;
using nn::Tape;
using nn::Tensor;
using nn::Var;

constexpr Index kPoints = Sample::kPoints;

/// One pair over time that turns and grows, one stereo pair of a slanted plane.
std::vector<Sample> two_pairs() {
  std::vector<Sample> samples;
  samples.emplace_back(MatchKind::kFlow, 21, [](double x, double y) {
    return Displacement{9.4 + 0.03 * (x - 50.0) - 0.02 * (y - 50.0), -6.3 + 0.02 * (x - 50.0)};
  });
  samples.emplace_back(MatchKind::kStereo, 22, [](double, double y) {
    return Displacement{-11.7 - 0.06 * y, 0.0};
  });
  return samples;
}

double median_error(MatchNetwork<float>& network, const Sample& s) {
  Tape<float> tape(nn::Mode::kInference);
  const MatchPrediction p = match_pair(tape, network, s.pair, s.points, s.kind).prediction;
  const Tensor<float> wanted = nn::cast<float>(s.truth.displacement);
  const Index D = wanted.shape().channels();
  std::vector<double> errors;
  for (Index i = 0; i < kPoints; ++i) {
    double square = 0.0;
    for (Index d = i * D; d < (i + 1) * D; ++d) {
      const auto error = static_cast<double>(tape.data(p.displacement)[d] - wanted[d]);
      square += error * error;
    }
    errors.push_back(std::sqrt(square));
  }
  std::nth_element(errors.begin(), errors.begin() + kPoints / 2, errors.end());
  return errors[kPoints / 2];
}

TEST(MatchTraining, LearnsTwoPairsToHalfAPixel) {
  Random random(31);
  MatchNetwork<float> network(tiny_match_network(), random);
  const std::vector<Sample> samples = two_pairs();
  imslam::testing::train(
      network, [&](int) { return samples; }, 300);
  for (const Sample& s : samples) {
    const double error = median_error(network, s);
    RecordProperty(s.kind == MatchKind::kFlow ? "flow_px" : "stereo_px", std::to_string(error));
    EXPECT_LT(error, 0.5) << (s.kind == MatchKind::kFlow ? "flow" : "stereo");
  }
}

TEST(MatchTraining, GivesTheSameBytesForAnyNumberOfThreads) {
  const std::vector<Sample> samples = two_pairs();
  const auto trained = [&](int threads) {
    set_thread_count(threads);
    Random random(31);
    MatchNetwork<float> network(tiny_match_network(), random);
    imslam::testing::train(
        network, [&](int) { return samples; }, 3);
    set_thread_count(0);
    return network;
  };
  MatchNetwork<float> one = trained(1);
  MatchNetwork<float> three = trained(3);
  const nn::ParameterList<float> a = parameters_of(one);
  const nn::ParameterList<float> b = parameters_of(three);
  for (std::size_t k = 0; k < a.count(); ++k) {
    for (Index i = 0; i < a[k].value.size(); ++i) {
      ASSERT_EQ(a[k].value[i], b[k].value[i]) << a[k].name;
    }
  }
}

}  // namespace
}  // namespace imslam::vo
