#include "slam/base/progress.hpp"

#include <gtest/gtest.h>

namespace imslam {
namespace {

TEST(ProgressBar, ShowsBarCountRateAndTimeLeft) {
  EXPECT_EQ(ProgressBar::line("run", 50, 200, 10.0, "", 200),
            "run [#######.......................] 50/200  5.0/s  left 0:30");
}

TEST(ProgressBar, WithoutATotalShowsCountAndRate) {
  EXPECT_EQ(ProgressBar::line("read", 42, 0, 2.0, "x", 200), "read 42  21.0/s  x");
}

TEST(ProgressBar, AtTheEndNothingIsLeft) {
  EXPECT_EQ(ProgressBar::line("run", 200, 200, 10.0, "", 200),
            "run [##############################] 200/200  20.0/s");
}

TEST(ProgressBar, MoreThanTheTotalAndNoTimeDoNotBreakIt) {
  EXPECT_EQ(ProgressBar::line("run", 300, 200, 0.0, "", 200),
            "run [##############################] 300/200  0.0/s");
}

TEST(ProgressBar, IsCutToTheWidthOfTheTerminal) {
  EXPECT_EQ(ProgressBar::line("run", 1, 2, 1.0, "note", 10).size(), 10U);
  EXPECT_EQ(ProgressBar::line("run", 1, 2, 1.0, "note", 0), "");
}

TEST(ProgressBar, MinutesAreCountedOn) {
  EXPECT_NE(ProgressBar::line("run", 1, 7201, 1.0, "", 200).find("left 120:00"), std::string::npos);
}

TEST(ProgressBar, IsSilentWhereStderrIsNoTerminal) {
  ::testing::internal::CaptureStderr();
  {
    ProgressBar bar("run");
    for (std::size_t i = 0; i <= 10; ++i) bar.update(i, 10);
  }
  EXPECT_EQ(::testing::internal::GetCapturedStderr(), "");
}

}  // namespace
}  // namespace imslam
