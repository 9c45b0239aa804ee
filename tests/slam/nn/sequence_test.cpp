#include "slam/nn/ops/attention.hpp"
#include "slam/nn/ops/dropout.hpp"
#include "slam/nn/ops/layout.hpp"
#include "slam/nn/ops/recurrent.hpp"
#include "tests/slam/nn/check_op.hpp"

namespace imslam::nn {
namespace {

using testing::check_op;
using testing::random_tensor;
using Vars = std::vector<Var>;

// x, h0, wx, bx, wh, bh
const std::vector<Shape> kGru{{2, 4, 3}, {2, 2}, {3, 6}, {6}, {2, 6}, {6}};

TEST(Gru, Gradients) {
  check_op([](auto& t, const Vars& v) { return gru(t, v[0], v[1], v[2], v[3], v[4], v[5]); }, kGru);
  check_op([](auto& t,
              const Vars& v) { return last_state(t, gru(t, v[0], v[1], v[2], v[3], v[4], v[5])); },
           kGru);
  check_op([](auto& t, const Vars& v) { return gru_cell(t, v[0], v[1], v[2], v[3], v[4], v[5]); },
           {{2, 3}, {2, 2}, {3, 6}, {6}, {2, 6}, {6}});
}

std::vector<Var> random_gru(Tape<double>& t) {
  Random random(5);
  std::vector<Var> v;
  for (const Shape& shape : kGru) v.push_back(t.constant(random_tensor(shape, random, -1, 1)));
  return v;
}

TEST(Gru, EqualsTheFormulas) {
  Tape<double> t;
  const std::vector<Var> v = random_gru(t);
  const Tensor<double> y = t.copy(gru(t, v[0], v[1], v[2], v[3], v[4], v[5]));
  const auto sigmoid = [](double x) { return 1.0 / (1.0 + std::exp(-x)); };
  for (Index n = 0; n < 2; ++n) {
    Eigen::VectorXd h = t.matrix(v[1]).row(n);
    for (Index k = 0; k < 4; ++k) {
      const Eigen::VectorXd a =
          t.matrix(v[2]).transpose() * t.matrix(v[0]).row(n * 4 + k).transpose() +
          t.matrix(v[3]).row(0).transpose();
      const Eigen::VectorXd c = t.matrix(v[4]).transpose() * h + t.matrix(v[5]).row(0).transpose();
      for (Index i = 0; i < 2; ++i) {
        const double r = sigmoid(a[i] + c[i]);
        const double z = sigmoid(a[2 + i] + c[2 + i]);
        const double candidate = std::tanh(a[4 + i] + r * c[4 + i]);
        h[i] = (1 - z) * candidate + z * h[i];
        ASSERT_NEAR(y[(n * 4 + k) * 2 + i], h[i], 1e-14);
      }
    }
  }
}

TEST(Gru, ASequenceInTwoPiecesWithTheStateBetweenIsTheWhole) {
  Tape<double> t;
  const std::vector<Var> v = random_gru(t);
  const Var whole = gru(t, v[0], v[1], v[2], v[3], v[4], v[5]);
  const Var first = gru(t, slice(t, v[0], 1, 0, 1), v[1], v[2], v[3], v[4], v[5]);
  const Var rest = gru(t, slice(t, v[0], 1, 1, 3), last_state(t, first), v[2], v[3], v[4], v[5]);
  EXPECT_TRUE((t.array(concat(t, {first, rest}, 1)) == t.array(whole)).all());
}

TEST(Gru, TheFutureDoesNotChangeThePast) {
  Tape<double> t;
  const std::vector<Var> v = random_gru(t);
  const Var y = gru(t, v[0], v[1], v[2], v[3], v[4], v[5]);
  Tensor<double> other = t.copy(v[0]);
  other[3 * 3] += 1.0;  // sample 0, last step
  const Var changed = gru(t, t.constant(other), v[1], v[2], v[3], v[4], v[5]);
  const Var before = slice(t, y, 1, 0, 3);
  EXPECT_TRUE((t.array(before) == t.array(slice(t, changed, 1, 0, 3))).all());
  EXPECT_NE(t.data(y)[3 * 2], t.data(changed)[3 * 2]);
}

TEST(Attention, Gradients) {
  check_op([](auto& t, const Vars& v) { return attention(t, v[0], v[1], v[2], 2); },
           {{2, 3, 4}, {2, 5, 4}, {2, 5, 6}});
  check_op(
      [](auto& t, const Vars& v) { return attention(t, v[0], v[0], v[0], 1, causal_mask(t, 4)); },
      {{2, 4, 2}});
}

TEST(Attention, EqualsTheFormulaHeadByHead) {
  Random random(12);
  const Tensor<double> q = random_tensor({1, 3, 4}, random, -1, 1);
  const Tensor<double> k = random_tensor({1, 5, 4}, random, -1, 1);
  const Tensor<double> v = random_tensor({1, 5, 6}, random, -1, 1);
  Tape<double> t;
  const Tensor<double> y = t.copy(attention(t, t.constant(q), t.constant(k), t.constant(v), 2));
  for (Index h = 0; h < 2; ++h) {
    Eigen::MatrixXd weights = (q.matrix().middleCols(2 * h, 2) *
                               k.matrix().middleCols(2 * h, 2).transpose() / std::sqrt(2.0))
                                  .array()
                                  .exp();
    weights = weights.array().colwise() / weights.rowwise().sum().array().eval();
    const Eigen::MatrixXd expected = weights * v.matrix().middleCols(3 * h, 3);
    EXPECT_LE((y.matrix().middleCols(3 * h, 3) - expected).cwiseAbs().maxCoeff(), 1e-14);
  }
}

TEST(Dropout, KeepsTheMeanRepeatsForASeedAndIsOffInInference) {
  Tensor<float> ones({100000});
  ones.array() = 1.0F;
  const auto run = [&](Mode mode, std::uint64_t seed) {
    Tape<float> t(mode);
    Random random(seed);
    return t.copy(dropout(t, t.input(ones), 0.25, random));
  };
  const Tensor<float> y = run(Mode::kTraining, 1);
  EXPECT_NEAR(y.array().cast<double>().mean(), 1.0, 0.01);
  EXPECT_NEAR((y.array() == 0.0F).cast<double>().mean(), 0.25, 0.01);
  EXPECT_TRUE((y.array() == run(Mode::kTraining, 1).array()).all());
  EXPECT_FALSE((y.array() == run(Mode::kTraining, 2).array()).all());
  EXPECT_TRUE((run(Mode::kInference, 1).array() == 1.0F).all());
}

TEST(Dropout, Gradients) {
  check_op(
      [](auto& t, const Vars& v) {
        Random random(3);
        // Inference leaves everything as it is; the check compares the two modes.
        return t.training() ? dropout(t, v[0], 0.0, random) : v[0];
      },
      {{3, 4}});
  Tape<double> t;
  Random random(3);
  const Var x = t.input(Tensor<double>({4}, {1, 2, 3, 4}));
  const Var y = dropout(t, x, 0.5, random);
  t.backward(y, Tensor<double>({4}, {1, 1, 1, 1}));
  EXPECT_TRUE((t.gradient(x) * t.array(x) == t.array(y)).all());
}

}  // namespace
}  // namespace imslam::nn
