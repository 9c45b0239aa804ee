#include "slam/base/random.hpp"

#include <gtest/gtest.h>

#include <array>
#include <cmath>

#include "slam/base/error.hpp"

namespace imslam {
namespace {

TEST(Random, RepeatsForASeedAndDiffersForAnother) {
  Random a(42);
  Random b(42);
  Random c(43);
  int equal = 0;
  for (int i = 0; i < 1000; ++i) {
    const std::uint64_t bits = a.bits();
    EXPECT_EQ(bits, b.bits());
    equal += bits == c.bits() ? 1 : 0;
  }
  EXPECT_EQ(equal, 0);
}

// Kept forever: a changed stream would change every simulated world and trained network.
TEST(Random, FirstValuesAreGolden) {
  Random random(1);
  EXPECT_EQ(random.bits(), 9822250072823399003ULL);
  EXPECT_EQ(random.bits(), 16467381930425171000ULL);
  EXPECT_DOUBLE_EQ(random.uniform(), 0.89049588741896235);
  EXPECT_DOUBLE_EQ(random.normal(), 0.13814673399753571);
  EXPECT_EQ(random.fork(5).bits(), 16565989503905994155ULL);
}

TEST(Random, UniformHasTheRightMomentsAndBounds) {
  constexpr int kCount = 200000;
  Random random(7);
  double sum = 0.0;
  double squares = 0.0;
  std::array<int, 10> bins{};
  for (int i = 0; i < kCount; ++i) {
    const double x = random.uniform();
    ASSERT_GE(x, 0.0);
    ASSERT_LT(x, 1.0);
    sum += x;
    squares += x * x;
    ++bins.at(static_cast<std::size_t>(10.0 * x));
  }
  const double mean = sum / kCount;
  EXPECT_NEAR(mean, 0.5, 4.0 * std::sqrt(1.0 / 12.0 / kCount));
  EXPECT_NEAR(squares / kCount - mean * mean, 1.0 / 12.0, 1e-3);
  double chi_square = 0.0;
  for (const int count : bins) chi_square += std::pow(count - kCount / 10.0, 2) / (kCount / 10.0);
  EXPECT_LT(chi_square, 27.9);  // 99.9 % for 9 degrees of freedom
}

TEST(Random, NormalHasTheRightMoments) {
  constexpr int kCount = 200000;
  Random random(8);
  std::array<double, 4> moments{};
  double product = 0.0;  // of neighbours: the two numbers of a pair must be independent
  double last = 0.0;
  for (int i = 0; i < kCount; ++i) {
    const double x = random.normal();
    moments[0] += x / kCount;
    moments[1] += x * x / kCount;
    moments[2] += x * x * x / kCount;
    moments[3] += x * x * x * x / kCount;
    product += x * last / kCount;
    last = x;
  }
  const double sigma = 1.0 / std::sqrt(static_cast<double>(kCount));
  EXPECT_NEAR(moments[0], 0.0, 4.0 * sigma);
  EXPECT_NEAR(moments[1], 1.0, 4.0 * std::sqrt(2.0) * sigma);
  EXPECT_NEAR(moments[2], 0.0, 4.0 * std::sqrt(15.0) * sigma);
  EXPECT_NEAR(moments[3], 3.0, 4.0 * std::sqrt(96.0) * sigma);
  EXPECT_NEAR(product, 0.0, 4.0 * sigma);
}

TEST(Random, IntegersReachBothEndsEvenly) {
  Random random(9);
  std::array<int, 5> counts{};
  for (int i = 0; i < 50000; ++i) {
    const std::int64_t value = random.integer(-2, 2);
    ASSERT_GE(value, -2);
    ASSERT_LE(value, 2);
    ++counts.at(static_cast<std::size_t>(value + 2));
  }
  for (const int count : counts) EXPECT_NEAR(count, 10000, 400);
  EXPECT_EQ(random.integer(3, 3), 3);
  EXPECT_THROW(random.integer(1, 0), ContractError);
}

TEST(Random, HugeRangesDoNotOverflow) {
  Random random(9);
  bool negative = false;
  bool positive = false;
  for (int i = 0; i < 1000; ++i) {
    const std::int64_t value = random.integer(INT64_MIN, INT64_MAX);
    negative = negative || value < INT64_MAX / -2;
    positive = positive || value > INT64_MAX / 2;
  }
  EXPECT_TRUE(negative);
  EXPECT_TRUE(positive);
}

TEST(Random, ForksDoNotDependOnWhatWasDrawn) {
  Random used(5);
  for (int i = 0; i < 100; ++i) used.normal();
  EXPECT_EQ(used.fork(3).bits(), Random(5).fork(3).bits());
  EXPECT_NE(used.fork(3).bits(), used.fork(4).bits());
  EXPECT_NE(used.fork(0).bits(), Random(5).bits());
}

TEST(Random, ChanceHappensAsOftenAsAsked) {
  Random random(6);
  int hits = 0;
  for (int i = 0; i < 100000; ++i) hits += random.chance(0.2) ? 1 : 0;
  EXPECT_NEAR(hits, 20000, 600);
  EXPECT_FALSE(random.chance(0.0));
  EXPECT_TRUE(random.chance(1.0));
}

}  // namespace
}  // namespace imslam
