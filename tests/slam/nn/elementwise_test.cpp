#include "slam/nn/ops/activation.hpp"
#include "slam/nn/ops/arithmetic.hpp"
#include "slam/nn/ops/pointwise.hpp"
#include "tests/slam/nn/check_op.hpp"

namespace imslam::nn {
namespace {

using testing::check_op;
using testing::CheckOptions;
using testing::run_op;
using Vars = std::vector<Var>;

const std::vector<Shape> kOne{{3, 7}};
const CheckOptions kPositive{0.2, 2.0};
const CheckOptions kWide{-3.0, 3.0};

TEST(Activation, GradientsOfAllFunctions) {
  check_op([](auto& t, const Vars& v) { return relu(t, v[0]); }, kOne, kWide);
  check_op([](auto& t, const Vars& v) { return leaky_relu(t, v[0], 0.2); }, kOne, kWide);
  check_op([](auto& t, const Vars& v) { return add_relu(t, v[0], v[1]); }, {{3, 37}, {3, 37}},
           kWide);
  check_op([](auto& t, const Vars& v) { return elu(t, v[0]); }, kOne, kWide);
  check_op([](auto& t, const Vars& v) { return gelu(t, v[0]); }, kOne, kWide);
  check_op([](auto& t, const Vars& v) { return silu(t, v[0]); }, kOne, kWide);
  check_op([](auto& t, const Vars& v) { return tanh(t, v[0]); }, kOne, kWide);
  check_op([](auto& t, const Vars& v) { return sigmoid(t, v[0]); }, kOne, kWide);
  check_op([](auto& t, const Vars& v) { return softplus(t, v[0]); }, kOne, kWide);
}

TEST(Activation, KnownValuesAndFarTails) {
  Tape<double> t(Mode::kInference);
  const Var x = t.constant(Tensor<double>({5}, {-800.0, -1.0, 0.0, 1.0, 800.0}));
  const auto at = [&](Var y, Index i) { return t.data(y)[i]; };
  EXPECT_NEAR(at(sigmoid(t, x), 3), 1.0 / (1.0 + std::exp(-1.0)), 1e-15);
  EXPECT_NEAR(at(softplus(t, x), 1), std::log1p(std::exp(-1.0)), 1e-15);
  EXPECT_NEAR(at(silu(t, x), 1), -1.0 / (1.0 + std::exp(1.0)), 1e-15);
  EXPECT_NEAR(at(elu(t, x), 1), std::expm1(-1.0), 1e-15);
  EXPECT_NEAR(at(gelu(t, x), 3), 0.5 * (1.0 + std::erf(std::sqrt(0.5))), 2e-4);
  EXPECT_DOUBLE_EQ(at(leaky_relu(t, x), 1), -0.1);
  EXPECT_DOUBLE_EQ(at(softplus(t, x), 4), 800.0);
  EXPECT_DOUBLE_EQ(at(softplus(t, x), 0), 0.0);
  EXPECT_DOUBLE_EQ(at(sigmoid(t, x), 0), 0.0);
  EXPECT_DOUBLE_EQ(at(elu(t, x), 4), 800.0);
}

TEST(Pointwise, GradientsOfAllFunctions) {
  check_op([](auto& t, const Vars& v) { return exp(t, v[0]); }, kOne);
  check_op([](auto& t, const Vars& v) { return log(t, v[0]); }, kOne, kPositive);
  check_op([](auto& t, const Vars& v) { return sqrt(t, v[0]); }, kOne, kPositive);
  check_op([](auto& t, const Vars& v) { return abs(t, v[0]); }, kOne);
  check_op([](auto& t, const Vars& v) { return square(t, v[0]); }, kOne);
  check_op([](auto& t, const Vars& v) { return clamp(t, v[0], -0.4, 0.5); }, kOne);
  check_op([](auto& t, const Vars& v) { return scale(t, v[0], -2.5); }, kOne);
  check_op([](auto& t, const Vars& v) { return shift(t, v[0], 0.75); }, kOne);
}

TEST(Pointwise, StopGradientKeepsTheValueOnly) {
  Tape<double> t;
  const Var x = t.input(Tensor<double>({1}, {3.0}));
  const Var y = multiply(t, x, stop_gradient(t, x));
  t.backward(y);
  EXPECT_DOUBLE_EQ(t.number(y), 9.0);
  EXPECT_DOUBLE_EQ(*t.gradient_data(x), 3.0);
}

TEST(Arithmetic, GradientsOfEqualShapes) {
  const std::vector<Shape> same{{3, 5}, {3, 5}};
  check_op([](auto& t, const Vars& v) { return add(t, v[0], v[1]); }, same);
  check_op([](auto& t, const Vars& v) { return subtract(t, v[0], v[1]); }, same);
  check_op([](auto& t, const Vars& v) { return multiply(t, v[0], v[1]); }, same);
  check_op([](auto& t, const Vars& v) { return divide(t, v[0], v[1]); }, same, kPositive);
}

TEST(Arithmetic, GradientsOfRepeatedOperands) {
  const auto product = [](auto& t, const Vars& v) { return multiply(t, v[0], v[1]); };
  check_op(product, {{2, 3, 4}, {4}});
  check_op(product, {{4}, {2, 3, 4}});
  check_op(product, {{2, 3, 4}, {2, 1, 4}});
  check_op(product, {{2, 3, 4}, {2, 3, 1}});
  check_op(product, {{2, 1, 3}, {5, 1}});
  check_op(product, {{2, 3, 4}, {1}});
  check_op(product, {{2, 3}, {}});
  check_op(product, {{2, 3, 2, 1, 4}, {3, 1, 5, 1}});
  check_op([](auto& t, const Vars& v) { return divide(t, v[0], v[1]); }, {{3, 1}, {2, 3, 4}},
           kPositive);
}

TEST(Arithmetic, BroadcastingPairsTheRightNumbers) {
  Tape<double> t;
  const Var column = t.constant(Tensor<double>({2, 1}, {10, 20}));
  const Var row = t.constant(Tensor<double>({3}, {1, 2, 3}));
  const Tensor<double> y = t.copy(add(t, column, row));
  EXPECT_EQ(y.shape(), (Shape{2, 3}));
  const std::vector<double> expected{11, 12, 13, 21, 22, 23};
  for (Index i = 0; i < 6; ++i) EXPECT_EQ(y[i], expected[static_cast<std::size_t>(i)]);
}

TEST(Arithmetic, ShapesThatDoNotFitAreNamed) {
  Tape<float> t;
  const Var a = t.constant(Tensor<float>({2, 3}));
  const Var b = t.constant(Tensor<float>({4}));
  try {
    add(t, a, b);
    FAIL() << "expected a ContractError";
  } catch (const ContractError& error) {
    EXPECT_NE(std::string(error.what()).find("[2,3] and [4]"), std::string::npos) << error.what();
  }
}

TEST(Arithmetic, AnOperandMayBeUsedTwice) {
  check_op([](auto& t, const Vars& v) { return multiply(t, v[0], add(t, v[0], v[0])); }, kOne);
}

}  // namespace
}  // namespace imslam::nn
