#include "slam/evaluation/statistics.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "slam/base/error.hpp"

namespace imslam::evaluation {
namespace {

TEST(Statistics, OfAnEvenNumberOfErrors) {
  const Statistics s = statistics({4.0, 1.0, 2.0, 3.0});
  EXPECT_DOUBLE_EQ(s.mean, 2.5);
  EXPECT_DOUBLE_EQ(s.median, 2.5);
  EXPECT_DOUBLE_EQ(s.sse, 30.0);
  EXPECT_DOUBLE_EQ(s.rmse, std::sqrt(7.5));
  EXPECT_DOUBLE_EQ(s.std, std::sqrt(1.25));  // population, not sample
  EXPECT_DOUBLE_EQ(s.min, 1.0);
  EXPECT_DOUBLE_EQ(s.max, 4.0);
}

TEST(Statistics, OfAnOddNumberTakeTheMiddleOne) {
  EXPECT_DOUBLE_EQ(statistics({5.0, 1.0, 2.0}).median, 2.0);
}

TEST(Statistics, DoNotCancelForLargeNearlyEqualErrors) {
  EXPECT_NEAR(statistics({1e9 + 1.0, 1e9 + 2.0, 1e9 + 3.0}).std, std::sqrt(2.0 / 3.0), 1e-9);
}

TEST(Statistics, OfErrorsWhoseSquaresOverflowAreRefused) {
  for (const double huge : {1e200, 1e308}) {
    try {
      statistics({1.0, huge, huge});
      ADD_FAILURE() << "expected InputError of " << huge;
    } catch (const InputError& error) {
      EXPECT_EQ(error.code(), ExitCode::kEvaluation);
    }
  }
  EXPECT_DOUBLE_EQ(statistics({1e150, 1e150}).rmse, 1e150);
}

TEST(Statistics, OfNothingAreABug) { EXPECT_THROW(statistics({}), ContractError); }

}  // namespace
}  // namespace imslam::evaluation
