#include "slam/nn/ops/normalise.hpp"
#include "slam/nn/ops/arithmetic.hpp"
#include "slam/nn/ops/softmax.hpp"
#include "tests/slam/nn/check_op.hpp"

namespace imslam::nn {
namespace {

using testing::check_op;
using testing::CheckOptions;
using testing::constant;
using testing::random_tensor;
using Vars = std::vector<Var>;

TEST(Softmax, Gradients) {
  check_op([](auto& t, const Vars& v) { return softmax(t, v[0]); }, {{3, 5}});
  check_op([](auto& t, const Vars& v) { return log_softmax(t, v[0]); }, {{3, 5}});
  const Tensor<double> mask({2, 3}, {1, 0, 1, 1, 1, 0});
  check_op([&](auto& t, const Vars& v) { return softmax(t, v[0], constant(t, mask)); },
           {{2, 2, 3}});
}

TEST(LogSoftmax, GradientsOfWhatTheMaskLeaves) {
  const Tensor<double> mask({3}, {1, 0, 1});
  check_op(
      [&](auto& t, const Vars& v) {
        // Only the sum of probabilities sees masked channels: their logarithm is no number.
        const Var y = log_softmax(t, v[0], constant(t, mask));
        return softmax(t, y, constant(t, mask));
      },
      {{2, 3}});
}

TEST(Softmax, SumsToOneAndSurvivesLargeNumbers) {
  Tape<float> t(Mode::kInference);
  const Var x = t.constant(Tensor<float>({2, 3}, {1e4F, 1e4F, -1e4F, -3e4F, -3e4F, -3e4F}));
  const Var y = softmax(t, x);
  EXPECT_FLOAT_EQ(t.data(y)[0], 0.5F);
  EXPECT_FLOAT_EQ(t.data(y)[2], 0.0F);
  EXPECT_FLOAT_EQ(t.data(y)[3], 1.0F / 3.0F);
  EXPECT_TRUE(t.array(log_softmax(t, x)).isFinite().all());
}

TEST(Softmax, ARowThatIsMaskedAwayIsZero) {
  Tape<double> t;
  const Var x = t.input(Tensor<double>({1, 2}, {1.0, 2.0}));
  const Var y = softmax(t, x, t.constant(Tensor<double>({2})));
  t.backward(y, Tensor<double>({1, 2}, {1.0, -1.0}));
  EXPECT_EQ(t.array(y).abs().maxCoeff(), 0.0);
  EXPECT_EQ(t.gradient(x).abs().maxCoeff(), 0.0);
}

TEST(SoftmaxSummary, Gradients) {
  check_op([](auto& t, const Vars& v) { return softmax_summary(t, v[0]); }, {{2, 3, 5}});
}

TEST(SoftmaxSummary, IsLargestProbabilityAndEntropyOfASoftmax) {
  Random random(4);
  Tape<double> t;
  const Var x = t.constant(random_tensor({30, 81}, random, -20.0, 20.0));
  const Var p = softmax(t, x);
  const Var surprise = multiply(t, p, log_softmax(t, x));
  const Var y = softmax_summary(t, x);
  for (Index r = 0; r < 30; ++r) {
    EXPECT_NEAR(t.data(y)[2 * r], t.matrix(p).row(r).maxCoeff(), 1e-14);
    EXPECT_NEAR(t.data(y)[2 * r + 1], -t.matrix(surprise).row(r).sum(), 1e-13);
  }
}

TEST(SoftmaxSummary, SurvivesLargeNumbers) {
  Tape<float> t(Mode::kInference);
  const Var y = softmax_summary(
      t, t.constant(Tensor<float>({2, 3}, {1e4F, 1e4F, -1e4F, -3e4F, -3e4F, -3e4F})));
  EXPECT_FLOAT_EQ(t.data(y)[0], 0.5F);
  EXPECT_FLOAT_EQ(t.data(y)[1], std::log(2.0F));
  EXPECT_FLOAT_EQ(t.data(y)[2], 1.0F / 3.0F);
  EXPECT_FLOAT_EQ(t.data(y)[3], std::log(3.0F));
}

TEST(Norm, Gradients) {
  CheckOptions loose;
  loose.tolerance = 1e-6;
  check_op([](auto& t, const Vars& v) { return layer_norm(t, v[0], v[1], v[2]); },
           {{2, 3, 5}, {5}, {5}}, loose);
  check_op([](auto& t, const Vars& v) { return layer_norm(t, v[0], Var{}, Var{}); }, {{3, 5}},
           loose);
  check_op([](auto& t, const Vars& v) { return group_norm(t, v[0], v[1], v[2], 2); },
           {{2, 3, 2, 4}, {4}, {4}}, loose);
  check_op([](auto& t, const Vars& v) { return instance_norm(t, v[0], v[1], v[2]); },
           {{2, 3, 3, 2}, {2}, {2}}, loose);
  check_op([](auto& t, const Vars& v) { return batch_norm(t, v[0], v[1], v[2]).y; },
           {{2, 3, 3, 2}, {2}, {2}}, loose);
  check_op([](auto& t, const Vars& v) { return l2_normalise(t, v[0]); }, {{2, 3, 4}}, loose);
}

TEST(Norm, EachSetHasMeanZeroAndVarianceOne) {
  Random random(2);
  Tape<double> t;
  const Var x = t.constant(random_tensor({2, 5, 7, 6}, random, 3.0, 9.0));
  const Var y = group_norm(t, x, Var{}, Var{}, 3);
  for (Index n = 0; n < 2; ++n) {
    for (Index g = 0; g < 3; ++g) {
      const auto set = t.matrix(y).block(n * 35, g * 2, 35, 2).array();
      EXPECT_NEAR(set.mean(), 0.0, 1e-12);
      EXPECT_NEAR(set.square().mean(), 1.0, 1e-4);
    }
  }
}

TEST(Norm, InstanceNormOfOneSampleIsFiniteOnAConstantImage) {
  Tape<float> t;
  Tensor<float> black({1, 4, 4, 3});
  const Var x = t.input(black);
  const Var y = instance_norm(t, x, Var{}, Var{});
  t.backward(y, Tensor<float>({1, 4, 4, 3}));
  EXPECT_EQ(t.array(y).abs().maxCoeff(), 0.0F);
  EXPECT_TRUE(t.gradient(x).isFinite().all());
}

TEST(Norm, L2OfAZeroRowIsZero) {
  Tape<float> t;
  const Var y = l2_normalise(t, t.constant(Tensor<float>({1, 8})));
  EXPECT_EQ(t.array(y).abs().maxCoeff(), 0.0F);
}

}  // namespace
}  // namespace imslam::nn
