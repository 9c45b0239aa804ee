#include "vo_net/motion_noise.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "slam/base/error.hpp"
#include "slam/nn/weights_io.hpp"
#include "tests/support/temp_dir.hpp"
#include "tests/vo_net/synthetic_points.hpp"

namespace imslam::vo {
namespace {

constexpr int kCount = MotionNoiseFeatures::kCount;

struct Measured {
  Correspondences points;
  PoseLayerResult pose;
  StereoCamera camera = testing::test_camera();

  MotionNoiseFeatures features() const { return motion_noise_features(pose, points, camera); }
};

Measured measured() {
  Measured m;
  Random random(4);
  m.points =
      testing::synthetic_correspondences(m.camera, testing::test_motion(), 200, {0.3, 0.3}, random);
  m.pose = solve_pose(m.points, m.camera, {});
  return m;
}

MotionNoise<float> shaken_network() {
  Random random(6);
  MotionNoise<float> network(random);
  for (nn::Index i = 0; i < network.output.weight.value.size(); ++i) {
    network.output.weight.value[i] = static_cast<float>(random.normal());
  }
  return network;
}

TEST(MotionNoise, UntrainedItChangesNothing) {
  Random random(6);
  const MotionNoise<float> network(random);
  EXPECT_EQ(noise_factors(network, measured().features()), (Eigen::Matrix<double, 6, 1>::Ones()));
}

TEST(MotionNoise, FactorsAreOneForTranslationAndOneForRotation) {
  const Eigen::Matrix<double, 6, 1> factors = noise_factors(0.5, -1.0);
  for (int axis = 0; axis < 3; ++axis) {
    EXPECT_DOUBLE_EQ(factors[axis], std::exp(0.5));
    EXPECT_DOUBLE_EQ(factors[3 + axis], std::exp(-1.0));
  }
}

TEST(MotionNoise, WhateverItSeesTheFactorsStayBounded) {
  const MotionNoise<float> network = shaken_network();
  for (const float size : {0.0F, 1.0F, -30.0F, 1e6F}) {
    MotionNoiseFeatures features;
    features.values.fill(size);
    const Eigen::Matrix<double, 6, 1> factors = noise_factors(network, features);
    EXPECT_LE(factors.maxCoeff(), std::exp(3.0) * (1.0 + 1e-6));
    EXPECT_GE(factors.minCoeff(), std::exp(-3.0) * (1.0 - 1e-6));
  }
}

TEST(MotionNoise, RowsOfABatchAreAnsweredAlone) {
  const MotionNoise<float> network = shaken_network();
  const MotionNoiseFeatures one = measured().features();
  MotionNoiseFeatures other = one;
  other.values[0] += 1.0F;
  nn::Tensor<float> both({2, kCount});
  std::copy(one.values.begin(), one.values.end(), both.data());
  std::copy(other.values.begin(), other.values.end(), both.data() + kCount);
  nn::Tape<float> tape(nn::Mode::kInference);
  const nn::Var said = network.forward(tape, tape.constant(both.shape(), both.data()));
  const float* const answer = tape.data(said);
  EXPECT_NEAR(std::exp(answer[0]), noise_factors(network, one)[0], 1e-5);
  EXPECT_NEAR(std::exp(answer[3]), noise_factors(network, other)[5], 1e-5);
  EXPECT_NE(answer[0], answer[2]);
}

TEST(MotionNoise, FeaturesOfAnOrdinaryMotionAreOfTheSizeOfOne) {
  for (const float value : measured().features().values) EXPECT_LT(std::abs(value), 3.0F);
}

TEST(MotionNoise, FeaturesSpeakOfTheInliersOnly) {
  Measured m = measured();
  const MotionNoiseFeatures before = m.features();
  Correspondence stray = m.points[0];
  stray.disparity0 = 500.0;
  stray.left1.x() += 300.0;
  stray.weight = 0.0;
  stray.learned.left1 = true;
  m.points.push_back(stray);
  m.pose.is_inlier.push_back(0);
  const MotionNoiseFeatures after = m.features();
  for (std::size_t i = 0; i < kCount; ++i) {
    if (i == 1) continue;
    EXPECT_EQ(after.values[i], before.values[i]) << i;
  }
  EXPECT_LT(after.values[1], before.values[1]);  // their share
}

TEST(MotionNoise, FeaturesFollowWhatTheyDescribe) {
  const Measured plain = measured();
  const MotionNoiseFeatures before = plain.features();
  const auto changed = [&](auto change) {
    Measured m = plain;
    change(m);
    const MotionNoiseFeatures after = m.features();
    std::vector<std::size_t> different;
    for (std::size_t i = 0; i < kCount; ++i) {
      if (after.values[i] != before.values[i]) different.push_back(i);
    }
    return different;
  };
  using Indices = std::vector<std::size_t>;
  EXPECT_EQ(changed([](Measured& m) { m.pose.noise_scale *= 2.0; }), Indices({0}));
  EXPECT_EQ(changed([](Measured& m) { m.points[0].learned.left1 = true; }), Indices({3}));
  EXPECT_EQ(changed([](Measured& m) { m.points[0].weight = 0.5; }), Indices({4}));
  EXPECT_EQ(changed([](Measured& m) { m.pose.covariance.topRows<3>() *= 2.0; }), Indices({5}));
  EXPECT_EQ(changed([](Measured& m) { m.pose.covariance.bottomRows<3>() *= 2.0; }), Indices({6}));
  EXPECT_EQ(changed([](Measured& m) {
              for (Correspondence& c : m.points) c.disparity0 *= 2.0;
            }),
            Indices({7}));
  EXPECT_EQ(changed([](Measured& m) {
              for (Correspondence& c : m.points) c.left1 += c.left1 - c.left0;
            }),
            Indices({8}));
}

TEST(MotionNoise, WithoutInliersTheFeaturesAreFinite) {
  Measured m = measured();
  std::fill(m.pose.is_inlier.begin(), m.pose.is_inlier.end(), 0);
  for (const float value : m.features().values) EXPECT_TRUE(std::isfinite(value));
  m.points.clear();
  m.pose.is_inlier.clear();
  for (const float value : m.features().values) EXPECT_TRUE(std::isfinite(value));
}

TEST(MotionNoise, IsReadBackWithItsCardAndOtherFilesAreRefused) {
  const testing::TempDir dir;
  const std::string file = (dir.path() / "motion_noise.safetensors").string();
  MotionNoise<float> network = shaken_network();
  nn::ParameterList<float> parameters;
  network.collect(parameters);
  nn::ModelCard card;
  card.what = "a test";
  nn::save_parameters(file, parameters, card);
  const TrainedMotionNoise read = load_motion_noise(file);
  const MotionNoiseFeatures features = measured().features();
  EXPECT_EQ(noise_factors(*read.network, features), noise_factors(network, features));
  EXPECT_EQ(read.file, file);
  EXPECT_EQ(read.card.what, "a test");
  EXPECT_EQ(read.card.sha256.size(), 64U);

  EXPECT_THROW(load_motion_noise((dir.path() / "absent").string()), InputError);
  nn::ParameterList<float> part;
  network.hidden.collect(part, "hidden.");
  nn::save_parameters(file, part, card);
  EXPECT_THROW(load_motion_noise(file), InputError);
}

}  // namespace
}  // namespace imslam::vo
