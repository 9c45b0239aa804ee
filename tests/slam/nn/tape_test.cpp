#include "slam/nn/tape.hpp"

#include <gtest/gtest.h>

#include <cstdint>

#include "slam/base/random.hpp"
#include "slam/nn/ops/activation.hpp"
#include "slam/nn/ops/arithmetic.hpp"
#include "slam/nn/ops/layout.hpp"
#include "slam/nn/ops/pointwise.hpp"
#include "slam/nn/ops/reduce.hpp"

namespace imslam::nn {
namespace {

TEST(Shape, CountsAndNamesItself) {
  const Shape shape{2, 3, 4};
  EXPECT_EQ(shape.size(), 24);
  EXPECT_EQ(shape.rows(), 6);
  EXPECT_EQ(shape.channels(), 4);
  EXPECT_EQ(shape[-2], 3);
  EXPECT_EQ(shape.text(), "[2,3,4]");
  EXPECT_EQ(Shape{}.size(), 1);
  EXPECT_EQ((Shape{5, 0}.rows()), 5);
  EXPECT_EQ(shape.without(0), (Shape{3, 4}));
}

TEST(Shape, RefusesNegativeAndOverflowingSizes) {
  EXPECT_THROW((Shape{2, -1}), ContractError);
  EXPECT_THROW((Shape{Index{1} << 40, Index{1} << 40}), ContractError);
  EXPECT_THROW((Shape{1, 1, 1, 1, 1, 1}), ContractError);
  EXPECT_THROW((Shape{2}[1]), ContractError);
}

TEST(Arena, PiecesAreAlignedAndReusedAfterARewind) {
  Arena arena;
  void* const first = arena.allocate(10);
  void* const second = arena.allocate(3 << 20);
  EXPECT_EQ(reinterpret_cast<std::uintptr_t>(first) % Arena::kAlignment, 0U);
  EXPECT_EQ(reinterpret_cast<std::uintptr_t>(second) % Arena::kAlignment, 0U);
  const std::size_t held = arena.capacity();
  arena.rewind();
  EXPECT_EQ(arena.allocate(10), first);
  EXPECT_EQ(arena.allocate(3 << 20), second);
  EXPECT_EQ(arena.capacity(), held);
}

TEST(Dual, IsTheDerivative) {
  const Dual<double> x(0.7, 1.0);
  EXPECT_DOUBLE_EQ((x * x * x).tangent, 3 * 0.49);
  EXPECT_DOUBLE_EQ((Dual<double>(1.0) / x).tangent, -1.0 / 0.49);
  EXPECT_DOUBLE_EQ(exp(x).tangent, std::exp(0.7));
  EXPECT_DOUBLE_EQ(log(x).tangent, 1.0 / 0.7);
  EXPECT_DOUBLE_EQ(log1p(x).tangent, 1.0 / 1.7);
  EXPECT_DOUBLE_EQ(expm1(x).tangent, std::exp(0.7));
  EXPECT_DOUBLE_EQ(sqrt(x).tangent, 0.5 / std::sqrt(0.7));
  EXPECT_DOUBLE_EQ(tanh(x).tangent, 1.0 - std::pow(std::tanh(0.7), 2));
  EXPECT_DOUBLE_EQ(erf(x).tangent, 2.0 / std::sqrt(M_PI) * std::exp(-0.49));
  EXPECT_DOUBLE_EQ(abs(-x).tangent, 1.0);
}

TEST(Dual, NestsToSecondDerivatives) {
  const Dual<Dual<double>> x({0.7, 1.0}, {1.0, 0.0});
  EXPECT_DOUBLE_EQ((x * x * x).tangent.tangent, 6 * 0.7);
  EXPECT_DOUBLE_EQ(exp(x).tangent.tangent, std::exp(0.7));
}

TEST(Tape, AParameterUsedTwiceHasOneGradient) {
  Parameter<double> w(Shape{1});
  w.value[0] = 3.0;
  ParameterList<double> list;
  list.add("w", w);
  Tape<double> t;
  const Var first = t.parameter(w);
  EXPECT_EQ(t.parameter(w).id, first.id);
  t.backward(multiply(t, first, t.parameter(w)));
  Gradients<double> sums = zero_gradients(list);
  t.add_gradients_to(list, sums);
  t.add_gradients_to(list, sums);
  EXPECT_DOUBLE_EQ(sums[0][0], 12.0);
}

TEST(Tape, FrozenParametersAndConstantsGetNoGradient) {
  Parameter<double> w(Shape{1}, false);
  Tape<double> t;
  const Var y = multiply(t, t.parameter(w), t.constant(Tensor<double>({1}, {2.0})));
  EXPECT_FALSE(t.wants_gradient(y));
  t.backward(y);  // nothing to do, no error
}

TEST(Tape, GradientsOfLeavesAddUpOverCallsUntilTheyAreCleared) {
  Tape<double> t;
  const Var x = t.input(Tensor<double>({1}, {3.0}));
  const Var y = square(t, scale(t, x, 2.0));
  t.backward(y);
  EXPECT_DOUBLE_EQ(*t.gradient_data(x), 24.0);
  t.backward(y);
  EXPECT_DOUBLE_EQ(*t.gradient_data(x), 48.0);
  t.clear_gradients();
  t.backward(y);
  EXPECT_DOUBLE_EQ(*t.gradient_data(x), 24.0);
}

TEST(Tape, AReshapedValueAndItsOriginalShareGradientsRightly) {
  Tape<double> t;
  const Var x = t.input(Tensor<double>({2}, {3.0, 4.0}));
  const Var twice = scale(t, x, 2.0);
  const Var flat = reshape(t, twice, {2, 1});
  // `twice` is read before and after the reshape that lends it its gradient.
  const Var y = add(t, sum(t, square(t, twice)), sum(t, flat));
  t.backward(y);
  EXPECT_DOUBLE_EQ(t.gradient_data(x)[0], 2 * (2 * 6.0 + 1));
  EXPECT_DOUBLE_EQ(t.gradient_data(x)[1], 2 * (2 * 8.0 + 1));
}

TEST(Tape, HessianVectorProductsComeOutOfDualGradients) {
  // f = sum x^3: gradient 3 x^2, Hessian diag(6 x).
  Tape<Dual<double>> t;
  const Var x = t.input(Tensor<Dual<double>>({2}, {{1.0, 0.5}, {2.0, -1.0}}));
  t.backward(sum(t, multiply(t, x, square(t, x))));
  EXPECT_DOUBLE_EQ(t.gradient_data(x)[0].value, 3.0);
  EXPECT_DOUBLE_EQ(t.gradient_data(x)[0].tangent, 6.0 * 0.5);
  EXPECT_DOUBLE_EQ(t.gradient_data(x)[1].tangent, 12.0 * -1.0);
}

TEST(Tape, RejectsForeignValuesWrongSeedsAndBackwardInInference) {
  Tape<float> t;
  EXPECT_THROW(t.shape(Var{}), ContractError);
  EXPECT_THROW(t.shape(Var{7}), ContractError);
  const Var x = t.input(Tensor<float>({2}));
  EXPECT_THROW(t.backward(x), ContractError);
  EXPECT_THROW(t.backward(x, Tensor<float>({3})), ContractError);
  Tape<float> plain(Mode::kInference);
  EXPECT_THROW(plain.backward(plain.input(Tensor<float>({1}))), ContractError);
}

TEST(Tape, ObservationsBlendIntoParametersOnlyWhenApplied) {
  Parameter<float> mean(Shape{1}, false);
  mean.value[0] = 1.0F;
  Tape<float> t;
  t.observe(mean, t.constant(Tensor<float>({1}, {5.0F})), 0.25);
  EXPECT_EQ(mean.value[0], 1.0F);
  t.apply_observations();
  EXPECT_EQ(mean.value[0], 2.0F);
  t.apply_observations();
  EXPECT_EQ(mean.value[0], 2.0F);
}

TEST(ParameterList, RefusesTheSameNameTwice) {
  Parameter<float> a(Shape{1});
  Parameter<float> b(Shape{1});
  ParameterList<float> list;
  list.add("layer.weight", a);
  EXPECT_THROW(list.add("layer.weight", b), ContractError);
}

}  // namespace
}  // namespace imslam::nn
