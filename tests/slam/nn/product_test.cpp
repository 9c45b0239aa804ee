#include "slam/nn/ops/product.hpp"
#include "slam/nn/ops/activation.hpp"
#include "slam/nn/ops/convolution.hpp"
#include "tests/slam/nn/check_op.hpp"

namespace imslam::nn {
namespace {

using testing::check_op;
using testing::random_tensor;
using Vars = std::vector<Var>;

ConvolutionOptions uneven() {
  ConvolutionOptions options;
  options.stride_y = 2;
  options.padding_y = 1;
  options.padding_x = 2;
  options.dilation_x = 2;
  return options;
}

TEST(Linear, Gradients) {
  check_op([](auto& t, const Vars& v) { return linear(t, v[0], v[1], v[2]); },
           {{2, 3, 4}, {4, 5}, {5}});
  check_op([](auto& t, const Vars& v) { return linear(t, v[0], v[1], Var{}); }, {{3, 4}, {4, 2}});
  check_op(
      [](auto& t, const Vars& v) { return linear(t, v[0], v[1], v[2], Activation::kLeakyRelu); },
      {{3, 4}, {4, 5}, {5}});
}

TEST(Linear, NoRowsGiveNoRows) {
  Tape<float> t;
  const Var y = linear(t, t.constant(Tensor<float>({0, 4})), t.constant(Tensor<float>({4, 2})), {});
  EXPECT_EQ(t.shape(y), (Shape{0, 2}));
}

TEST(Linear, RejectsAWrongNumberOfChannels) {
  Tape<float> t;
  const Var x = t.constant(Tensor<float>({2, 3}));
  const Var w = t.constant(Tensor<float>({4, 5}));
  EXPECT_THROW(linear(t, x, w, Var{}), ContractError);
}

TEST(Matmul, Gradients) {
  const auto product = [](auto& t, const Vars& v) { return matmul(t, v[0], v[1]); };
  check_op(product, {{3, 4}, {4, 5}});
  check_op(product, {{2, 3, 4}, {2, 4, 5}});
  check_op(product, {{2, 2, 3, 4}, {2, 2, 4, 1}});
  check_op(product, {{2, 3, 4}, {4, 2}});
  check_op([](auto& t, const Vars& v) { return matmul(t, v[0], transpose(t, v[1])); },
           {{2, 3, 4}, {2, 5, 4}});
}

TEST(Matmul, EqualsEigen) {
  Random random(3);
  const Tensor<double> a = random_tensor({5, 7}, random, -1, 1);
  const Tensor<double> b = random_tensor({7, 6}, random, -1, 1);
  Tape<double> t;
  const Var y = matmul(t, t.constant(a), t.constant(b));
  EXPECT_LE((t.matrix(y) - a.matrix() * b.matrix()).cwiseAbs().maxCoeff(), 1e-14);
}

TEST(Conv2d, Gradients) {
  const auto build = [](const ConvolutionOptions& options) {
    return [options](auto& t, const Vars& v) { return conv2d(t, v[0], v[1], v[2], options); };
  };
  check_op(build(ConvolutionOptions::square(1, 1)), {{2, 4, 5, 2}, {3, 3, 2, 3}, {3}});
  check_op(build(ConvolutionOptions::square(2, 1)), {{1, 5, 6, 2}, {3, 3, 2, 3}, {3}});
  check_op(build(ConvolutionOptions::square(1, 2, 2)), {{1, 5, 5, 1}, {3, 3, 1, 2}, {2}});
  check_op(build(uneven()), {{1, 6, 7, 2}, {3, 2, 2, 2}, {2}});
  ConvolutionOptions fused = ConvolutionOptions::square(1, 1);
  fused.activation = Activation::kRelu;
  check_op(build(fused), {{1, 4, 4, 2}, {3, 3, 2, 3}, {3}});
  fused.activation = Activation::kLeakyRelu;
  check_op(build(fused), {{1, 4, 4, 2}, {3, 3, 2, 3}, {3}});
}

// The definition, written down once more with nothing shared.
TEST(Conv2d, EqualsTheDefinition) {
  Random random(5);
  const Tensor<double> x = random_tensor({2, 6, 7, 2}, random, -1, 1);
  const Tensor<double> w = random_tensor({3, 2, 2, 3}, random, -1, 1);
  const Tensor<double> b = random_tensor({3}, random, -1, 1);
  Tape<double> t;
  const Var y = conv2d(t, t.constant(x), t.constant(w), t.constant(b), uneven());
  ASSERT_EQ(t.shape(y), (Shape{2, 3, 9, 3}));
  for (Index n = 0, at = 0; n < 2; ++n) {
    for (Index i = 0; i < 3; ++i) {
      for (Index j = 0; j < 9; ++j) {
        for (Index d = 0; d < 3; ++d, ++at) {
          double sum = b[d];
          for (Index k = 0; k < 3; ++k) {
            for (Index l = 0; l < 2; ++l) {
              const Index row = 2 * i + k - 1;
              const Index column = j + 2 * l - 2;
              if (row < 0 || row >= 6 || column < 0 || column >= 7) continue;
              for (Index c = 0; c < 2; ++c) {
                sum += x[((n * 6 + row) * 7 + column) * 2 + c] * w[((k * 2 + l) * 2 + c) * 3 + d];
              }
            }
          }
          ASSERT_NEAR(t.data(y)[at], sum, 1e-14);
        }
      }
    }
  }
}

TEST(Conv2d, FusedActivationEqualsTheActivationAfterwards) {
  Random random(9);
  Tape<float> t(Mode::kInference);
  const Var x = t.constant(cast<float>(random_tensor({1, 9, 11, 3}, random, -1, 1)));
  const Var w = t.constant(cast<float>(random_tensor({3, 3, 3, 8}, random, -1, 1)));
  ConvolutionOptions options = ConvolutionOptions::square(1, 1);
  const Var apart = leaky_relu(t, conv2d(t, x, w, Var{}, options));
  options.activation = Activation::kLeakyRelu;
  const Var fused = conv2d(t, x, w, Var{}, options);
  EXPECT_LE((t.array(apart) - t.array(fused)).abs().maxCoeff(), 1e-6F);
}

TEST(Conv1d, Gradients) {
  check_op(
      [](auto& t, const Vars& v) {
        return conv1d(t, v[0], v[1], v[2], ConvolutionOptions::square(2, 1, 2));
      },
      {{2, 9, 3}, {3, 3, 2}, {2}});
}

TEST(TransposedConv2d, Gradients) {
  check_op(
      [](auto& t, const Vars& v) {
        return transposed_conv2d(t, v[0], v[1], v[2], ConvolutionOptions::square(2, 1));
      },
      {{2, 3, 4, 2}, {4, 4, 3, 2}, {3}});
}

// <conv(a), b> = <a, transposed(b)> for all a, b.
TEST(TransposedConv2d, IsTheTransposeOfConv2d) {
  Random random(4);
  const auto options = ConvolutionOptions::square(2, 1);
  Tape<double> t;
  const Var a = t.constant(random_tensor({1, 7, 9, 2}, random, -1, 1));
  const Var b = t.constant(random_tensor({1, 4, 5, 3}, random, -1, 1));
  const Var w = t.constant(random_tensor({3, 3, 2, 3}, random, -1, 1));
  const Var down = conv2d(t, a, w, Var{}, options);
  const Var up = transposed_conv2d(t, b, w, Var{}, options);
  ASSERT_EQ(t.shape(up), t.shape(a));
  EXPECT_NEAR((t.array(down) * t.array(b)).sum(), (t.array(a) * t.array(up)).sum(), 1e-12);
}

}  // namespace
}  // namespace imslam::nn
