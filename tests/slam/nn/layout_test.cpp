#include "slam/nn/ops/layout.hpp"
#include "slam/nn/ops/gather.hpp"
#include "slam/nn/ops/reduce.hpp"
#include "tests/slam/nn/check_op.hpp"

namespace imslam::nn {
namespace {

using testing::check_op;
using testing::constant;
using Vars = std::vector<Var>;

Tensor<double> counting(const Shape& shape) {
  Tensor<double> numbers(shape);
  for (Index i = 0; i < numbers.size(); ++i) numbers[i] = static_cast<double>(i);
  return numbers;
}

void expect_numbers(const Tensor<double>& actual, const std::vector<double>& expected) {
  ASSERT_EQ(actual.size(), static_cast<Index>(expected.size()));
  for (Index i = 0; i < actual.size(); ++i) {
    EXPECT_EQ(actual[i], expected[static_cast<std::size_t>(i)]) << "at " << i;
  }
}

TEST(Layout, Gradients) {
  const std::vector<Shape> one{{2, 3, 4}};
  check_op([](auto& t, const Vars& v) { return reshape(t, v[0], {4, 6}); }, one);
  check_op([](auto& t, const Vars& v) { return permute(t, v[0], {2, 0, 1}); }, one);
  check_op([](auto& t, const Vars& v) { return slice(t, v[0], 1, 1, 2); }, one);
  check_op([](auto& t, const Vars& v) { return slice(t, v[0], -1, 3, 1); }, one);
  check_op([](auto& t, const Vars& v) { return pad(t, v[0], 1, 2, 1); }, one);
  check_op([](auto& t, const Vars& v) { return expand(t, v[0], {2, 3, 4}); }, {{3, 1}});
  check_op(
      [](auto& t, const Vars& v) {
        return concat(t, {v[0], v[1], v[0]}, 1);
      },
      {{2, 3, 2}, {2, 1, 2}});
  check_op([](auto& t, const Vars& v) { return concat(t, {v[0], v[1]}, -1); }, {{3, 2}, {3, 5}});
}

TEST(Layout, NumbersEndUpWhereTheyBelong) {
  Tape<double> t;
  const Var x = t.constant(counting({2, 3}));
  expect_numbers(t.copy(permute(t, x, {1, 0})), {0, 3, 1, 4, 2, 5});
  expect_numbers(t.copy(slice(t, x, 1, 1, 2)), {1, 2, 4, 5});
  expect_numbers(t.copy(pad(t, x, 0, 1, 0)), {0, 0, 0, 0, 1, 2, 3, 4, 5});
  expect_numbers(t.copy(concat(t, {x, slice(t, x, 1, 0, 1)}, 1)), {0, 1, 2, 0, 3, 4, 5, 3});
}

TEST(Layout, RejectsWhatDoesNotFit) {
  Tape<double> t;
  const Var x = t.constant(counting({2, 3}));
  EXPECT_THROW(reshape(t, x, {5}), ContractError);
  EXPECT_THROW(permute(t, x, {0, 0}), ContractError);
  EXPECT_THROW(slice(t, x, 1, 2, 2), ContractError);
  EXPECT_THROW(concat(t, {x, t.constant(counting({3, 3}))}, 1), ContractError);
}

TEST(Gather, Gradients) {
  const std::vector<std::int32_t> rows{2, 0, -1, 2};
  check_op([&](auto& t, const Vars& v) { return gather(t, v[0], rows); }, {{3, 2, 2}});
  check_op([&](auto& t, const Vars& v) { return scatter_add(t, v[0], rows, 3); }, {{4, 2}});
  check_op([&](auto& t, const Vars& v) { return pick(t, v[0], {1, 0, 2}); }, {{3, 3}});
}

TEST(Gather, NumbersEndUpWhereTheyBelong) {
  Tape<double> t;
  const Var x = t.constant(counting({3, 2}));
  expect_numbers(t.copy(gather(t, x, {2, -1, 0})), {4, 5, 0, 0, 0, 1});
  expect_numbers(t.copy(scatter_add(t, x, {1, 1, -1}, 2)), {0, 0, 2, 4});
  expect_numbers(t.copy(pick(t, x, {1, 0, 1})), {1, 2, 5});
  EXPECT_THROW(gather(t, x, {3}), ContractError);
  EXPECT_THROW(pick(t, x, {0, 2, 0}), ContractError);
}

TEST(Reduce, Gradients) {
  const std::vector<Shape> one{{2, 3, 4}};
  check_op([](auto& t, const Vars& v) { return sum(t, v[0], {1}); }, one);
  check_op([](auto& t, const Vars& v) { return sum(t, v[0], {0, 2}, Axes::kKeep); }, one);
  check_op([](auto& t, const Vars& v) { return mean(t, v[0], {-1}); }, one);
  check_op([](auto& t, const Vars& v) { return maximum(t, v[0], {1}); }, one);
  check_op([](auto& t, const Vars& v) { return maximum(t, v[0], {0, 1, 2}); }, one);
  check_op([](auto& t, const Vars& v) { return sum(t, v[0]); }, one);
  check_op([](auto& t, const Vars& v) { return mean(t, v[0]); }, one);
  const Tensor<double> mask({2, 3}, {1, 0, 1, 0, 0, 1});
  check_op([&](auto& t, const Vars& v) { return masked_mean(t, v[0], constant(t, mask)); },
           {{2, 3}});
}

TEST(Reduce, KnownNumbersAndShapes) {
  Tape<double> t;
  const Var x = t.constant(counting({2, 3}));
  expect_numbers(t.copy(sum(t, x, {0})), {3, 5, 7});
  expect_numbers(t.copy(mean(t, x, {1})), {1, 4});
  expect_numbers(t.copy(maximum(t, x, {1})), {2, 5});
  const Var no_rows = t.constant(Tensor<double>(Shape{0, 3}));
  EXPECT_EQ(t.shape(maximum(t, no_rows, {1})), (Shape{0}));
  EXPECT_THROW(maximum(t, no_rows, {0}), ContractError);
  EXPECT_EQ(t.shape(sum(t, x, {0}, Axes::kKeep)), (Shape{1, 3}));
  EXPECT_EQ(t.shape(sum(t, x, {0, 1})), Shape{});
  EXPECT_EQ(t.number(sum(t, x)), 15);
}

TEST(Reduce, AMaskHidesWhatIsNotANumber) {
  Tape<double> t;
  const Var x = t.input(Tensor<double>({3}, {1.0, std::nan(""), 3.0}));
  const Var y = masked_mean(t, x, t.constant(Tensor<double>({3}, {1, 0, 1})));
  EXPECT_EQ(t.number(y), 2.0);
  EXPECT_EQ(t.number(masked_mean(t, x, t.constant(Tensor<double>({3})))), 0.0);
}

TEST(Reduce, SumsOfFloatsKeepTheirDigits) {
  Tape<float> t;
  Tensor<float> many({1 << 22});
  many.array() = 0.1F;
  EXPECT_NEAR(t.number(mean(t, t.constant(many))), 0.1F, 1e-7F);
}

}  // namespace
}  // namespace imslam::nn
