#include "slam/nn/ops/correlation.hpp"
#include "slam/base/parallel.hpp"
#include "slam/nn/ops/sampling.hpp"
#include "tests/slam/nn/check_op.hpp"

namespace imslam::nn {
namespace {

using testing::check_op;
using testing::CheckOptions;
using testing::random_tensor;
using Vars = std::vector<Var>;

const Window kStereo{-3, 1, -1, 1, 1};

TEST(CostVolume, Gradients) {
  const auto volume = [](const Window& w) {
    return [w](auto& t, const Vars& v) { return cost_volume(t, v[0], v[1], w); };
  };
  check_op(volume(Window::square(1)), {{2, 3, 4, 2}, {2, 3, 4, 2}});
  check_op(volume(Window::square(2, 2)), {{1, 4, 4, 3}, {1, 4, 4, 3}});
  check_op(volume(kStereo), {{1, 3, 5, 2}, {1, 3, 5, 2}});
}

TEST(CostVolume, EqualsTheDefinition) {
  Random random(1);
  const Tensor<double> a = random_tensor({1, 4, 6, 3}, random, -1, 1);
  const Tensor<double> b = random_tensor({1, 4, 6, 3}, random, -1, 1);
  Tape<double> t;
  const Tensor<double> y = t.copy(cost_volume(t, t.constant(a), t.constant(b), kStereo));
  ASSERT_EQ(y.shape(), (Shape{1, 4, 6, 15}));
  Index at = 0;
  for (int i = 0; i < 4; ++i) {
    for (int j = 0; j < 6; ++j) {
      for (int dy = -1; dy <= 1; ++dy) {
        for (int dx = -3; dx <= 1; ++dx, ++at) {
          const bool inside = i + dy >= 0 && i + dy < 4 && j + dx >= 0 && j + dx < 6;
          const double expected =
              inside ? a.matrix().row(i * 6 + j).dot(b.matrix().row((i + dy) * 6 + j + dx)) : 0.0;
          ASSERT_NEAR(y[at], expected, 1e-14);
        }
      }
    }
  }
}

TEST(CorrelatePoints, Gradients) {
  const auto windows = [](const Window& w, Centre centre) {
    return [w, centre](auto& t, const Vars& v) {
      return correlate_points(t, v[0], v[1], v[2], w, centre);
    };
  };
  CheckOptions around;
  around.low = -0.9;
  around.high = 3.9;
  const std::vector<Shape> shapes{{2, 3, 2}, {2, 4, 4, 2}, {2, 3, 2}};
  check_op(windows(Window::square(1), Centre::kBilinear), shapes, around);
  check_op(windows(kStereo, Centre::kBilinear), shapes, around);
  check_op(windows(Window::square(2, 2), Centre::kRounded), shapes, around);
}

TEST(CorrelatePoints, BilinearEqualsSamplingAndMultiplying) {
  Random random(8);
  const Tensor<double> q = random_tensor({1, 5, 3}, random, -1, 1);
  const Tensor<double> b = random_tensor({1, 6, 7, 3}, random, -1, 1);
  const Tensor<double> centres = random_tensor({1, 5, 2}, random, -1, 7);
  Tape<double> t;
  const Var image = t.constant(b);
  const Tensor<double> y = t.copy(
      correlate_points(t, t.constant(q), image, t.constant(centres), kStereo, Centre::kBilinear));
  for (int k = 0; k < kStereo.count(); ++k) {
    Tensor<double> moved = centres.clone();
    moved.matrix().col(0).array() += kStereo.x(k);
    moved.matrix().col(1).array() += kStereo.y(k);
    const Var read = bilinear_sample(t, image, t.constant(moved), Border::kZero);
    for (Index i = 0; i < 5; ++i) {
      ASSERT_NEAR(y[i * kStereo.count() + k], q.matrix().row(i).dot(t.matrix(read).row(i)), 1e-13);
    }
  }
}

TEST(CorrelatePoints, RoundedTakesTheNearestPixelAndBadCentresGiveZero) {
  Tape<float> t;
  const Var q = t.constant(Tensor<float>({1, 3, 1}, {2.0F, 2.0F, 2.0F}));
  const Var b = t.constant(Tensor<float>({1, 1, 3, 1}, {1.0F, 10.0F, 100.0F}));
  const Var centres =
      t.constant(Tensor<float>({1, 3, 2}, {1.4F, 0.2F, 1.6F, -0.2F, std::nanf(""), 0.0F}));
  const Var y = correlate_points(t, q, b, centres, Window{}, Centre::kRounded);
  EXPECT_EQ(t.data(y)[0], 20.0F);
  EXPECT_EQ(t.data(y)[1], 200.0F);
  EXPECT_EQ(t.data(y)[2], 0.0F);
}

TEST(Correlation, EqualBytesForOneAndTwoThreads) {
  Random random(8);
  const Tensor<float> a = cast<float>(random_tensor({1, 20, 30, 16}, random, -1, 1));
  const Tensor<float> q = cast<float>(random_tensor({1, 300, 16}, random, -1, 1));
  const Tensor<float> centres = cast<float>(random_tensor({1, 300, 2}, random, 0, 20));
  const auto run = [&](int threads) {
    set_thread_count(threads);
    Tape<float> t;
    const Var image = t.input(a);
    const Var volume = cost_volume(t, image, t.constant(a), Window::square(3));
    const Var windows = correlate_points(t, t.constant(q), image, t.constant(centres),
                                         Window::square(3), Centre::kBilinear);
    t.backward(volume, t.copy(volume));
    t.backward(windows, t.copy(windows));
    set_thread_count(0);
    Tensor<float> gradient(a.shape());
    gradient.array() = t.gradient(image);
    return gradient;
  };
  const Tensor<float> one = run(1);
  const Tensor<float> two = run(2);
  EXPECT_TRUE((one.array() == two.array()).all());
}

TEST(Correlation, RejectsBilinearWindowsWithSteps) {
  Tape<float> t;
  const Var q = t.constant(Tensor<float>({1, 1, 1}));
  const Var b = t.constant(Tensor<float>({1, 1, 1, 1}));
  const Var c = t.constant(Tensor<float>({1, 1, 2}));
  EXPECT_THROW(correlate_points(t, q, b, c, Window::square(2, 2), Centre::kBilinear),
               ContractError);
}

}  // namespace
}  // namespace imslam::nn
