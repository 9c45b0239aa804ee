#include "vo_net/level_match.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "slam/nn/ops/product.hpp"
#include "slam/nn/ops/softmax.hpp"
#include "tests/slam/nn/check_op.hpp"

namespace imslam::vo {
namespace {

using nn::Tape;
using nn::Tensor;
using nn::Var;
using nn::Window;

TEST(LocalSoftArgmax, LiesBetweenTheLargestAndItsNeighbours) {
  const Window window{-2, 1, -1, 2, 1};
  Tensor<double> logits({1, 1, window.count()});
  logits.array() = -50.0;
  logits[4 + 1] = 2.0;  // (-1, 0)
  logits[4 + 2] = 2.0;  // (0, 0), as large
  logits[3] = 1.9;      // (1, -1): within one cell of the second only, the first is the choice
  logits[12] = 1.9;     // (-2, 2): two rows away
  Tape<double> tape;
  const Var y = local_soft_argmax(tape, tape.constant(logits), window);
  EXPECT_NEAR(tape.data(y)[0], -0.5, 1e-12);
  EXPECT_NEAR(tape.data(y)[1], 0.0, 1e-12);
}

TEST(LocalSoftArgmax, GradientMatchesCentralDifferences) {
  Random random(5);
  const Window window = Window::square(2);
  const Tensor<double> logits =
      nn::testing::random_tensor({2, 3, window.count()}, random, -3.0, 3.0);
  const Tensor<double> seed = nn::testing::random_tensor({2, 3, 2}, random, -1.0, 1.0);
  const auto build = [&](auto& tape, const std::vector<Var>& v) {
    return local_soft_argmax(tape, v[0], window);
  };
  const auto exact = nn::testing::run_op<double>(build, {logits}, &seed);
  nn::testing::check_gradients(build, {logits}, seed, exact, 1e-8);
}

/// The same as a masked softmax over the whole window.
Var plain_soft_argmax(Tape<double>& tape, Var logits, const Window& window, int radius) {
  const nn::Shape shape = tape.shape(logits);
  Tensor<double> mask(shape);
  Tensor<double> cells({window.count(), 2});
  for (int k = 0; k < window.count(); ++k) {
    cells[2 * k] = window.x(k);
    cells[2 * k + 1] = window.y(k);
  }
  for (nn::Index row = 0; row < shape.rows(); ++row) {
    const double* const x = tape.data(logits) + row * window.count();
    const auto best = static_cast<int>(std::max_element(x, x + window.count()) - x);
    for (int k = 0; k < window.count(); ++k) {
      const bool near = std::abs(window.x(k) - window.x(best)) <= radius * window.step &&
                        std::abs(window.y(k) - window.y(best)) <= radius * window.step;
      mask[row * window.count() + k] = near ? 1.0 : 0.0;
    }
  }
  return matmul(tape, softmax(tape, logits, tape.constant(mask)), tape.constant(cells));
}

TEST(LocalSoftArgmax, IsAMaskedSoftmaxOfTheWholeWindow) {
  Random random(6);
  for (const Window& window : {Window::square(4), Window::square(6, 2), Window{-24, 1, -1, 1, 1},
                               Window{0, 0, -3, 3, 1}}) {
    for (const int radius : {1, 2, 30}) {
      Tape<double> tape;
      const Var logits =
          tape.constant(nn::testing::random_tensor({40, window.count()}, random, -4.0, 4.0));
      const Var fast = local_soft_argmax(tape, logits, window, radius);
      const Var plain = plain_soft_argmax(tape, logits, window, radius);
      EXPECT_LE((tape.array(fast) - tape.array(plain)).abs().maxCoeff(), 1e-13);
    }
  }
}

TEST(LocalSoftArgmax, ARowWithoutNumbersHarmsNobody) {
  const Window window = Window::square(1);
  Tensor<float> logits({2, window.count()});
  logits.array().head(window.count()) = std::nanf("");
  Tape<float> tape;
  const Var y = local_soft_argmax(tape, tape.constant(logits), window);
  EXPECT_FLOAT_EQ(tape.data(y)[2], -0.5F);  // all alike: the first cell and its neighbours
}

}  // namespace
}  // namespace imslam::vo
