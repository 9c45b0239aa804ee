#include "slam/base/parallel.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <numeric>
#include <stdexcept>
#include <vector>

#include "slam/base/error.hpp"
#include "slam/base/random.hpp"

namespace imslam {
namespace {

class ParallelTest : public ::testing::Test {
 protected:
  ~ParallelTest() override { set_thread_count(0); }
};

std::vector<double> slots() {
  std::vector<double> values(1000);
  parallel_for(values.size(), [&](std::size_t i) {
    values[i] = std::sin(static_cast<double>(i)) + Random(1).fork(i).normal();
  });
  return values;
}

TEST_F(ParallelTest, ResultDoesNotDependOnTheNumberOfThreads) {
  set_thread_count(1);
  const std::vector<double> serial = slots();
  for (const int threads : {2, 4, 8}) {
    set_thread_count(threads);
    EXPECT_EQ(thread_count(), threads);
    EXPECT_EQ(slots(), serial);
  }
}

TEST_F(ParallelTest, EachIndexIsVisitedOnce) {
  std::vector<int> visits(10007, 0);
  parallel_for(visits.size(), [&](std::size_t i) { ++visits[i]; });
  EXPECT_EQ(std::accumulate(visits.begin(), visits.end(), 0), 10007);
  EXPECT_EQ(*std::max_element(visits.begin(), visits.end()), 1);
}

TEST_F(ParallelTest, NothingToDoIsFine) {
  parallel_for(0, [](std::size_t) { FAIL(); });
}

TEST_F(ParallelTest, ExceptionsReachTheCaller) {
  for (const int threads : {1, 4}) {
    set_thread_count(threads);
    EXPECT_THROW(parallel_for(100,
                              [](std::size_t i) {
                                if (i == 57) throw InputError("slot 57");
                              }),
                 InputError);
    EXPECT_EQ(slots().size(), 1000U);  // the pool still works
  }
}

TEST_F(ParallelTest, LoopsMayBeNested) {
  std::vector<std::vector<int>> rows(20, std::vector<int>(30, 0));
  parallel_for(rows.size(), [&](std::size_t i) {
    parallel_for(rows[i].size(), [&](std::size_t j) { rows[i][j] = static_cast<int>(i * j); });
  });
  EXPECT_EQ(rows[19][29], 19 * 29);
}

TEST_F(ParallelTest, AScopeHoldsTheProcessToOneThreadUntilItEnds) {
  set_thread_count(4);
  {
    const SingleThreadScope scope;
    EXPECT_EQ(thread_count(), 1);
  }
  EXPECT_EQ(thread_count(), 4);
}

TEST_F(ParallelTest, ANegativeNumberOfThreadsIsABug) {
  EXPECT_THROW(set_thread_count(-1), ContractError);
}

}  // namespace
}  // namespace imslam
