#include <gtest/gtest.h>

#include "slam/nn/layers/attention.hpp"
#include "slam/nn/layers/conv.hpp"
#include "slam/nn/layers/gru.hpp"
#include "slam/nn/layers/linear.hpp"
#include "slam/nn/layers/norm.hpp"
#include "tests/slam/nn/check_op.hpp"

namespace imslam::nn {
namespace {

using testing::random_tensor;

std::vector<std::string> names_of(const ParameterList<float>& list) {
  std::vector<std::string> names;
  for (const auto* parameter : list) names.push_back(parameter->name);
  return names;
}

TEST(Layers, NameTheirParameters) {
  Random random(1);
  Conv2d<float> conv(2, 4, 3, ConvolutionOptions::square(1, 1), random);
  BatchNorm<float> norm(4);
  Gru<float> gru(4, 3, random);
  ParameterList<float> list;
  conv.collect(list, "encoder.conv.");
  norm.collect(list, "encoder.norm.");
  gru.collect(list, "gru.");
  EXPECT_EQ(names_of(list),
            (std::vector<std::string>{
                "encoder.conv.weight", "encoder.conv.bias", "encoder.norm.gain",
                "encoder.norm.bias", "encoder.norm.running_mean", "encoder.norm.running_variance",
                "gru.weight_input", "gru.weight_hidden", "gru.bias_input", "gru.bias_hidden"}));
  EXPECT_EQ(list.number_count(), 9 * 8 + 4 + 8 + 4 * 9 + 3 * 9 + 9 + 9);
}

TEST(Layers, ACopiedLayerIsAnotherLayer) {
  Random random(1);
  Linear<float> layer(2, 2, random);
  Linear<float> copy = layer;
  copy.weight.value[0] += 1.0F;
  EXPECT_NE(copy.weight.value[0], layer.weight.value[0]);
}

TEST(Layers, AttentionAndConv1dKeepTheirShapes) {
  Random random(1);
  Tape<float> t;
  const Attention<float> attention(8, 6, 2, random);
  const Var x = t.constant(cast<float>(random_tensor({2, 3, 8}, random, -1, 1)));
  const Var context = t.constant(cast<float>(random_tensor({2, 5, 6}, random, -1, 1)));
  EXPECT_EQ(t.shape(attention.forward(t, x, context)), (Shape{2, 3, 8}));
  const Conv1d<float> conv(6, 4, 3, ConvolutionOptions::square(1, 0), random);
  EXPECT_EQ(t.shape(conv.forward(t, context)), (Shape{2, 3, 4}));
}

TEST(Initialise, VariancesAreThoseOfTheFans) {
  Random random(3);
  Parameter<double> weight({3, 3, 64, 128});
  initialise_kaiming(weight, random);
  EXPECT_NEAR(weight.value.array().square().mean(), 2.0 / (9 * 64), 0.02 * 2.0 / (9 * 64));
  initialise_xavier(weight, random);
  const double expected = 2.0 / (9 * 64 + 9 * 128);
  EXPECT_NEAR(weight.value.array().square().mean(), expected, 0.02 * expected);
  Random again(3);
  Parameter<double> same({3, 3, 64, 128});
  initialise_kaiming(same, again);
  initialise_xavier(same, again);
  EXPECT_TRUE((same.value.array() == weight.value.array()).all());
}

TEST(BatchNorm, RunningStatisticsApproachThoseOfTheData) {
  Random random(4);
  BatchNorm<double> norm(2);
  Tensor<double> x = random_tensor({500, 2}, random, -1, 1);
  x.matrix().col(1).array() = 3.0 + 2.0 * x.matrix().col(1).array();
  Tape<double> t;
  for (int i = 0; i < 200; ++i) {
    t.reset();
    norm.forward(t, t.constant(x));
    t.apply_observations();
  }
  const auto column = x.matrix().col(1).array();
  const double mean = column.mean();
  const double unbiased = (column - mean).square().sum() / 499.0;
  EXPECT_NEAR(norm.running_mean.value[1], mean, 1e-6);
  EXPECT_NEAR(norm.running_variance.value[1], unbiased, 1e-6);
}

TEST(BatchNorm, FoldsIntoTheConvolutionBeforeIt) {
  Random random(5);
  Conv2d<double> conv(2, 3, 3, ConvolutionOptions::square(1, 1), random);
  BatchNorm<double> norm(3);
  for (Index c = 0; c < 3; ++c) {
    norm.gain.value[c] = random.uniform(0.5, 2.0);
    norm.bias.value[c] = random.uniform(-1.0, 1.0);
    norm.running_mean.value[c] = random.uniform(-1.0, 1.0);
    norm.running_variance.value[c] = random.uniform(0.1, 2.0);
  }
  Tape<double> t(Mode::kInference);
  const Var x = t.constant(random_tensor({1, 5, 6, 2}, random, -1, 1));
  const Var apart = norm.forward(t, conv.forward(t, x));
  Conv2d<double> folded = conv;
  fold(norm, folded);
  EXPECT_LE((t.array(apart) - t.array(folded.forward(t, x))).abs().maxCoeff(), 1e-13);
}

TEST(BatchNorm, FrozenItUsesTheRunningStatisticsWhileTraining) {
  Random random(6);
  BatchNorm<double> norm(2);
  norm.frozen = true;
  norm.running_mean.value[0] = 5.0;
  Tape<double> t;
  const Var y = norm.forward(t, t.input(Tensor<double>({1, 2}, {5.0, 0.0})));
  EXPECT_NEAR(t.data(y)[0], 0.0, 1e-12);
  t.backward(y, Tensor<double>({1, 2}, {1.0, 1.0}));
  t.apply_observations();
  EXPECT_EQ(norm.running_mean.value[0], 5.0);
}

TEST(Norms, LayersApplyGainAndBias) {
  Random random(7);
  GroupNorm<double> group(4, 2);
  LayerNorm<double> layer(4);
  layer.gain.value.array() = 0.0;
  layer.bias.value.array() = 2.0;
  Tape<double> t;
  const Var x = t.constant(random_tensor({2, 3, 3, 4}, random, -1, 1));
  EXPECT_NEAR(t.array(group.forward(t, x)).mean(), 0.0, 1e-12);
  EXPECT_TRUE((t.array(layer.forward(t, x)) == 2.0).all());
}

// A network in dual numbers: the derivative of its output along a direction of its weights.
TEST(Layers, JacobianVectorProductsOfWeightsAgreeWithDifferences) {
  Random random(8);
  Linear<double> layer(3, 2, random);
  ParameterList<double> list;
  layer.collect(list, "");
  Linear<Dual<double>> dual(3, 2, random);
  ParameterList<Dual<double>> dual_list;
  dual.collect(dual_list, "");
  copy_values(list, dual_list);
  const Tensor<double> direction = random_tensor({3, 2}, random, -1, 1);
  for (Index i = 0; i < 6; ++i) dual.weight.value[i].tangent = direction[i];

  const Tensor<double> x = random_tensor({4, 3}, random, -1, 1);
  Tape<Dual<double>> t;
  const Var y = dual.forward(t, t.constant(cast<Dual<double>>(x)), Activation::kRelu);
  const auto at = [&](double step) {
    Linear<double> moved = layer;
    moved.weight.value.array() += step * direction.array();
    Tape<double> plain;
    return plain.copy(moved.forward(plain, plain.constant(x), Activation::kRelu));
  };
  const Tensor<double> ahead = at(1e-6);
  const Tensor<double> behind = at(-1e-6);
  for (Index i = 0; i < 8; ++i) {
    EXPECT_NEAR(t.data(y)[i].tangent, (ahead[i] - behind[i]) / 2e-6, 1e-8);
  }
}

}  // namespace
}  // namespace imslam::nn
