// Worse images through the executable; ../shared/reference/reliability.md, M13. The whole curve of
// severities: degradation_benchmark.
#include <gtest/gtest.h>

#include "tests/support/degradation.hpp"
#include "tests/support/run_check.hpp"

namespace imslam {
namespace {

using testing::Chaos;
using testing::Degradation;
using testing::expect_error_within;
using testing::run_checked;
using testing::TempDir;

class Degraded : public ::testing::TestWithParam<Degradation> {};

TEST_P(Degraded, CostsHalfAtSeverityThree) {
  TempDir dir;
  Chaos chaos(testing::simulated_base().sequence, dir.path() / "spoiled");
  GetParam().spoil(chaos, 3);
  const auto spoiled = run_checked(dir, chaos.folder());
  EXPECT_EQ(spoiled.counter("frames_degraded"), 0);
  expect_error_within(1.5, spoiled);
}

INSTANTIATE_TEST_SUITE_P(Images,
                         Degraded,
                         ::testing::ValuesIn(testing::degradations()),
                         [](const auto& each) { return std::string(each.param.name); });

}  // namespace
}  // namespace imslam
