#include "vo_net/level_match.hpp"

#include <gtest/gtest.h>

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

}  // namespace
}  // namespace imslam::vo
