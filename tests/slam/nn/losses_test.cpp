#include <Eigen/LU>
#include <cmath>

#include "slam/nn/ops/losses.hpp"
#include "slam/nn/ops/pointwise.hpp"
#include "slam/nn/ops/reduce.hpp"
#include "slam/nn/ops/softmax.hpp"
#include "tests/slam/nn/check_op.hpp"

namespace imslam::nn {
namespace {

using testing::check_op;
using testing::constant;
using testing::random_tensor;
using Vars = std::vector<Var>;

constexpr double kPi = 3.14159265358979323846;
const std::vector<Shape> kTwo{{3, 4}, {3, 4}};

TEST(Losses, Gradients) {
  check_op([](auto& t, const Vars& v) { return absolute_error(t, v[0], v[1]); }, kTwo);
  check_op([](auto& t, const Vars& v) { return squared_error(t, v[0], v[1]); }, kTwo);
  check_op([](auto& t, const Vars& v) { return huber(t, v[0], v[1], 0.5); }, kTwo);
  check_op([](auto& t, const Vars& v) { return cross_entropy(t, v[0], {1, 3, 0}); }, {{3, 4}});
  check_op([](auto& t, const Vars& v) { return soft_cross_entropy(t, v[0], softmax(t, v[1])); },
           kTwo);
  check_op([](auto& t, const Vars& v) { return binary_cross_entropy_with_logits(t, v[0], v[1]); },
           kTwo);
  check_op([](auto& t, const Vars& v) { return gaussian_nll(t, v[0], v[1]); }, kTwo);
  check_op([](auto& t, const Vars& v) { return student_t_nll(t, v[0], v[1], 3.0); }, kTwo);
  check_op([](auto& t, const Vars& v) { return student_t_nll_2d(t, v[0], v[1], 3.0); },
           {{4, 2}, {4, 3}});
}

TEST(Losses, KnownNumbers) {
  Tape<double> t;
  const auto value = [&](Var y) { return t.number(y); };
  const auto number = [&](double x) { return t.constant(Tensor<double>({1}, {x})); };
  EXPECT_DOUBLE_EQ(value(huber(t, number(0.3), number(0.0), 0.5)), 0.045);
  EXPECT_DOUBLE_EQ(value(huber(t, number(-2.0), number(0.0), 0.5)), 0.5 * (2.0 - 0.25));
  const Var logits = t.constant(Tensor<double>({1, 2}, {0.0, std::log(3.0)}));
  EXPECT_NEAR(value(cross_entropy(t, logits, {1})), -std::log(0.75), 1e-15);
  EXPECT_NEAR(value(binary_cross_entropy_with_logits(t, number(std::log(3.0)), number(1.0))),
              -std::log(0.75), 1e-15);
  EXPECT_NEAR(value(binary_cross_entropy_with_logits(t, number(-1000.0), number(1.0))), 1000.0,
              1e-12);
}

/// Integral of e^-nll over the line: 1 for a likelihood.
template <typename Nll>
double mass(const Nll& nll) {
  constexpr double kStep = 0.01;
  double sum = 0.0;
  for (double r = -400.0; r <= 400.0; r += kStep) sum += kStep * std::exp(-nll(r));
  return sum;
}

TEST(Losses, LikelihoodsHaveMassOne) {
  const auto with = [](auto&& loss) {
    return [loss](double r) {
      Tape<double> t(Mode::kInference);
      return t.number(
          loss(t, t.constant(Tensor<double>({1}, {r})), t.constant(Tensor<double>({1}, {0.4}))));
    };
  };
  EXPECT_NEAR(mass(with([](auto& t, Var r, Var s) { return gaussian_nll(t, r, s); })), 1.0, 1e-6);
  EXPECT_NEAR(mass(with([](auto& t, Var r, Var s) { return student_t_nll(t, r, s, 4.0); })), 1.0,
              1e-6);
}

// For nu -> infinity the Student t becomes the Gaussian with the same factor.
TEST(Losses, StudentInTwoDimensionsTendsToTheGaussian) {
  Tape<double> t;
  const Var residual = t.constant(Tensor<double>({1, 2}, {0.3, -0.7}));
  const Var factor = t.constant(Tensor<double>({1, 3}, {0.2, -0.4, 0.5}));
  Eigen::Matrix2d L;
  L << std::exp(0.2), 0.0, 0.5, std::exp(-0.4);
  const Eigen::Vector2d whitened = L.inverse() * Eigen::Vector2d(0.3, -0.7);
  // L in the header is [e^s0 0; l e^s1]: the second row divides by e^s1 alone.
  const double expected =
      std::log(L.determinant()) + 0.5 * whitened.squaredNorm() + std::log(2.0 * kPi);
  EXPECT_NEAR(t.number(student_t_nll_2d(t, residual, factor, 1e7)), expected, 1e-5);
}

TEST(Losses, ScoreIsSmallestAtTheTrueScale) {
  Random random(2);
  Tensor<double> residual({20000});
  for (Index i = 0; i < residual.size(); ++i) residual[i] = 2.0 * random.normal();
  const auto at = [&](double sigma) {
    Tape<double> t(Mode::kInference);
    Tensor<double> scale(residual.shape());
    scale.array() = std::log(sigma);
    return t.number(mean(t, gaussian_nll(t, t.constant(residual), t.constant(scale))));
  };
  EXPECT_LT(at(2.0), at(1.7));
  EXPECT_LT(at(2.0), at(2.35));
}

TEST(Losses, DifferentShapesAreRejected) {
  Tape<double> t;
  const Var a = t.constant(Tensor<double>({2, 3}));
  const Var b = t.constant(Tensor<double>({3, 2}));
  EXPECT_THROW(huber(t, a, b, 1.0), ContractError);
  EXPECT_THROW(soft_cross_entropy(t, a, b), ContractError);
  EXPECT_THROW(student_t_nll_2d(t, b, a, 3.0), ContractError);
}

}  // namespace
}  // namespace imslam::nn
