#include "slam/nn/ops/pooling.hpp"
#include "slam/nn/ops/resize.hpp"
#include "slam/nn/ops/sampling.hpp"
#include "tests/slam/nn/check_op.hpp"

namespace imslam::nn {
namespace {

using testing::check_op;
using testing::CheckOptions;
using testing::random_tensor;
using Vars = std::vector<Var>;

TEST(Pooling, Gradients) {
  const std::vector<Shape> one{{2, 5, 6, 2}};
  check_op([](auto& t, const Vars& v) { return max_pool(t, v[0], 2, 2); }, one);
  check_op([](auto& t, const Vars& v) { return max_pool(t, v[0], 3, 1); }, one);
  check_op([](auto& t, const Vars& v) { return average_pool(t, v[0], 2, 2); }, one);
  check_op([](auto& t, const Vars& v) { return average_pool(t, v[0], 3, 2); }, one);
  check_op([](auto& t, const Vars& v) { return global_max_pool(t, v[0]); }, one);
  check_op([](auto& t, const Vars& v) { return global_average_pool(t, v[0]); }, one);
}

TEST(Pooling, KnownNumbers) {
  Tape<double> t;
  const Var x = t.constant(Tensor<double>({1, 2, 4, 1}, {1, 5, 2, 0, 3, 3, 8, 6}));
  const Tensor<double> largest = t.copy(max_pool(t, x, 2, 2));
  const Tensor<double> mean = t.copy(average_pool(t, x, 2, 2));
  EXPECT_EQ(largest.shape(), (Shape{1, 1, 2, 1}));
  EXPECT_EQ(largest[0], 5);
  EXPECT_EQ(largest[1], 8);
  EXPECT_EQ(mean[0], 3);
  EXPECT_EQ(mean[1], 4);
}

TEST(Resize, Gradients) {
  const std::vector<Shape> one{{2, 3, 4, 2}};
  check_op([](auto& t, const Vars& v) { return upsample2_nearest(t, v[0]); }, one);
  check_op([](auto& t, const Vars& v) { return upsample2_bilinear(t, v[0]); }, one);
  check_op([](auto& t, const Vars& v) { return resize_nearest(t, v[0], 5, 7); }, one);
  check_op([](auto& t, const Vars& v) { return resize_bilinear(t, v[0], 5, 7); }, one);
  check_op([](auto& t, const Vars& v) { return resize_bilinear(t, v[0], 2, 3); }, one);
  const std::vector<Shape> half{{2, 3, 2, 2}};
  check_op([](auto& t, const Vars& v) { return upsample2_aligned(t, v[0], 5, 4); }, half);
  check_op([](auto& t, const Vars& v) { return add_upsampled2(t, v[1], v[0]); },
           {{2, 3, 2, 2}, {2, 5, 4, 2}});
  check_op([](auto& t, const Vars& v) { return add_upsampled2(t, v[1], v[0]); },
           {{1, 2, 3, 35}, {1, 4, 5, 35}});
}

TEST(Resize, BilinearKeepsARampAndItsBorders) {
  Tape<double> t;
  const Var x = t.constant(Tensor<double>({1, 1, 3, 1}, {0, 4, 8}));
  const Tensor<double> y = t.copy(resize_bilinear(t, x, 2, 6));
  const std::vector<double> row{0, 1, 3, 5, 7, 8};
  for (Index i = 0; i < 12; ++i) EXPECT_DOUBLE_EQ(y[i], row[static_cast<std::size_t>(i % 6)]);
}

TEST(Resize, AlignedPutsEverySecondPixelOnAPixel) {
  Tape<double> t;
  const Var x = t.constant(Tensor<double>({1, 1, 3, 1}, {0, 4, 9}));
  const Tensor<double> odd = t.copy(upsample2_aligned(t, x, 1, 5));
  const Tensor<double> even = t.copy(upsample2_aligned(t, x, 2, 6));
  const std::vector<double> row{0, 2, 4, 6.5, 9, 9};
  for (Index i = 0; i < 5; ++i) EXPECT_DOUBLE_EQ(odd[i], row[static_cast<std::size_t>(i)]);
  for (Index i = 0; i < 12; ++i) EXPECT_DOUBLE_EQ(even[i], row[static_cast<std::size_t>(i % 6)]);
  EXPECT_THROW(upsample2_aligned(t, x, 1, 7), ContractError);
}

TEST(Resize, NearestTakesThePixelThatCoversTheCentre) {
  Tape<double> t;
  const Var x = t.constant(Tensor<double>({1, 1, 2, 1}, {3, 9}));
  const Tensor<double> y = t.copy(resize_nearest(t, x, 1, 3));
  EXPECT_EQ(y[0], 3);
  EXPECT_EQ(y[1], 9);
  EXPECT_EQ(y[2], 9);
}

TEST(Sampling, Gradients) {
  const auto sample = [](Border border) {
    return [border](auto& t, const Vars& v) { return bilinear_sample(t, v[0], v[1], border); };
  };
  CheckOptions around;
  around.low = -1.5;
  around.high = 5.5;
  check_op(sample(Border::kClamp), {{2, 4, 5, 2}, {2, 6, 2}}, around);
  check_op(sample(Border::kZero), {{2, 4, 5, 2}, {2, 6, 2}}, around);
  check_op([](auto& t, const Vars& v) { return warp(t, v[0], v[1], Border::kClamp); },
           {{2, 3, 4, 2}, {2, 2, 3, 2}});
}

TEST(Sampling, ReadsPixelsAndBetweenThem) {
  Tape<double> t;
  const Var image = t.constant(Tensor<double>({1, 2, 2, 1}, {1, 2, 3, 4}));
  const Var points = t.constant(Tensor<double>({1, 4, 2}, {0, 0, 1, 1, 0.5, 0.5, -3, 9}));
  const Tensor<double> clamped = t.copy(bilinear_sample(t, image, points, Border::kClamp));
  EXPECT_EQ(clamped[0], 1);
  EXPECT_EQ(clamped[1], 4);
  EXPECT_EQ(clamped[2], 2.5);
  EXPECT_EQ(clamped[3], 3);
  EXPECT_EQ(t.copy(bilinear_sample(t, image, points, Border::kZero))[3], 0);
}

TEST(Sampling, PointsThatAreNoPlacesReadZero) {
  Tape<float> t;
  const Var image = t.input(Tensor<float>({1, 1, 1, 1}, {5.0F}));
  const float nan = std::nanf("");
  const Var points = t.input(Tensor<float>({1, 2, 2}, {nan, 0.0F, 1e30F, 0.0F}));
  const Var y = bilinear_sample(t, image, points, Border::kClamp);
  t.backward(y, Tensor<float>({1, 2, 1}, {1.0F, 1.0F}));
  EXPECT_EQ(t.array(y).abs().maxCoeff(), 0.0F);
  EXPECT_EQ(t.gradient(points).abs().maxCoeff(), 0.0F);
}

TEST(Sampling, WarpByTheTrueFlowRestoresTheImage) {
  Random random(6);
  Tape<double> t;
  const Tensor<double> image = random_tensor({1, 6, 8, 1}, random, 0, 1);
  Tensor<double> flow({1, 6, 8, 2});
  for (Index i = 0; i < 48; ++i) flow[2 * i] = 2.0;
  const Tensor<double> y = t.copy(warp(t, t.constant(image), t.constant(flow), Border::kZero));
  for (Index i = 0; i < 6; ++i) {
    for (Index j = 0; j < 8; ++j) EXPECT_EQ(y[i * 8 + j], j < 6 ? image[i * 8 + j + 2] : 0.0);
  }
}

}  // namespace
}  // namespace imslam::nn
