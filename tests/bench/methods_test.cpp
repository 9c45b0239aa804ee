#include <gtest/gtest.h>

#include "slam/base/error.hpp"
#include "slam/base/random.hpp"
#include "slam/nn/weights_io.hpp"
#include "tests/support/temp_dir.hpp"
#include "tests/vo_net/synthetic_images.hpp"
#include "tools/bench/matching/experiment.hpp"
#include "vo_net/learned_options.hpp"
#include "vo_net/match_network.hpp"

namespace imslam::bench {
namespace {

using vo::MatchKind;

/// 320 x 240 px; what is at u in image 0 is at u - 6.3 in image 1.
struct ShiftedPair {
  ShiftedPair() : image0(blank()), image1(blank()) {
    Random random(7);
    const imslam::testing::SplineTexture texture(random, 5.0);
    for (int row = 0; row < 240; ++row) {
      for (int column = 0; column < 320; ++column) {
        const auto at = static_cast<std::size_t>(row * 320 + column);
        image0.pixels[at] = static_cast<std::uint8_t>(std::lround(texture.at(column, row)));
        image1.pixels[at] = static_cast<std::uint8_t>(std::lround(texture.at(column + 6.3, row)));
      }
    }
    for (int row = 40; row < 200; row += 20) {
      for (int column = 240; column < 300; column += 20) points.emplace_back(column, row);
    }
  }
  static GrayImage blank() { return {320, 240, std::vector<std::uint8_t>(320 * 240, 0)}; }

  GrayImage image0, image1;
  std::vector<Eigen::Vector2d> points;
};

/// `log_sigma`: what the heads say wherever they look.
std::filesystem::path untrained_weights(const imslam::testing::TempDir& folder, float log_sigma) {
  Random random(3);
  vo::MatchNetwork<float> network({}, random);
  nn::ParameterList<float> parameters;
  network.collect(parameters);
  // Outputs: mixing (4), residual (D), log sigma (D), ...; see match_head.cpp.
  for (const nn::Index i : {6, 7}) network.flow.head.output.bias.value[i] = log_sigma;
  network.stereo.head.output.bias.value[5] = log_sigma;
  const std::filesystem::path file = folder.path() / "untrained.safetensors";
  nn::save_parameters(file, parameters, {});
  return file;
}

TEST(BenchMethods, ClassicalOnesFindAShift) {
  const ShiftedPair pair;
  std::vector<std::unique_ptr<Method>> methods;
  methods.push_back(make_klt());
  methods.push_back(make_dis());
  methods.push_back(make_sgbm());
  for (const MatchKind kind : {MatchKind::kFlow, MatchKind::kStereo}) {
    for (const auto& method : methods) {
      if (method->names(kind).empty()) continue;
      const std::vector<Answer> answers =
          method->match(kind, pair.image0, pair.image1, pair.points);
      ASSERT_EQ(answers.size(), 1U);
      EXPECT_EQ(answers[0].method, method->names(kind)[0]);
      ASSERT_EQ(answers[0].matches.size(), pair.points.size());
      std::vector<double> errors;
      for (const PointMatch& match : answers[0].matches) {
        if (match.accepted) errors.push_back(std::abs(match.displacement.x() + 6.3));
      }
      EXPECT_GT(errors.size(), pair.points.size() / 2) << answers[0].method;
      EXPECT_LT(median(errors), 0.2) << answers[0].method << ' ' << kind_name(kind);
    }
  }
}

/// [px] by the front end's own limits; displacements over time are tried at coarser sizes, too.
double farthest_polish(MatchKind kind) {
  const vo::LearnedMatcherOptions limits;
  const bool coarse = kind == MatchKind::kFlow;
  return limits.max_polish_move * std::pow(2.0, coarse ? limits.coarse_polish : 0);
}

TEST(BenchMethods, TheNetworkReadsItsWeightsAndGivesTwoAnswers) {
  const imslam::testing::TempDir folder;
  const ShiftedPair pair;
  const auto network = make_network(untrained_weights(folder, 1.0F));
  for (const MatchKind kind : {MatchKind::kFlow, MatchKind::kStereo}) {
    const std::vector<Answer> answers = network->match(kind, pair.image0, pair.image1, pair.points);
    ASSERT_EQ(answers.size(), 2U);
    for (std::size_t a = 0; a < 2; ++a) {
      EXPECT_EQ(answers[a].method, network->names(kind)[a]);
      ASSERT_EQ(answers[a].matches.size(), pair.points.size());
    }
    for (std::size_t i = 0; i < pair.points.size(); ++i) {
      const PointMatch& raw = answers[0].matches[i];
      const PointMatch& polished = answers[1].matches[i];
      ASSERT_TRUE(raw.uncertainty.has_value());
      EXPECT_FALSE(polished.uncertainty.has_value());
      EXPECT_EQ(raw.accepted, raw.uncertainty->confidence > 0.5);
      EXPECT_EQ(raw.score, polished.score);
      EXPECT_GT(raw.uncertainty->scale(0, 0), 0.0);
      EXPECT_LE((raw.displacement - polished.displacement).norm(), farthest_polish(kind));
    }
  }
}

/// Errors where an image is matched with itself, summed over the raw answers that are less than 1
/// px off, and over the same points polished.
struct PolishedErrors {
  int points = 0;
  double raw = 0.0, polished = 0.0;  ///< [px]
};

PolishedErrors polished_errors(float log_sigma, MatchKind kind) {
  const imslam::testing::TempDir folder;
  const ShiftedPair pair;
  const auto answers = make_network(untrained_weights(folder, log_sigma))
                           ->match(kind, pair.image0, pair.image0, pair.points);
  PolishedErrors errors;
  for (std::size_t i = 0; i < pair.points.size(); ++i) {
    const double raw = answers[0].matches[i].displacement.norm();
    if (raw > 1.0) continue;
    ++errors.points;
    errors.raw += raw;
    errors.polished += answers[1].matches[i].displacement.norm();
  }
  return errors;
}

TEST(BenchMethods, ASureNetworkIsPolishedAnUnsureOneIsNot) {
  for (const MatchKind kind : {MatchKind::kFlow, MatchKind::kStereo}) {
    const PolishedErrors sure = polished_errors(-2.0F, kind);
    EXPECT_GT(sure.points, 5) << kind_name(kind);
    EXPECT_LT(sure.polished, 0.1 * sure.raw) << kind_name(kind);
    const PolishedErrors unsure = polished_errors(2.5F, kind);  // 21 px: beyond every size
    EXPECT_EQ(unsure.polished, unsure.raw) << kind_name(kind);
  }
}

TEST(BenchMethods, AFileOfOtherWeightsIsRefused) {
  const imslam::testing::TempDir folder;
  EXPECT_THROW(make_network(folder.write("wrong.safetensors", "no weights")), InputError);
}

}  // namespace
}  // namespace imslam::bench
