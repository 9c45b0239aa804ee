// Recordings that were cut or put together wrongly, through the executable;
// ../shared/reference/reliability.md, M14.
#include <gtest/gtest.h>

#include "tests/support/chaos.hpp"
#include "tests/support/run_check.hpp"

namespace imslam {
namespace {

using testing::Chaos;
using testing::CheckedRun;
using testing::clean_run;
using testing::run_checked;
using testing::TempDir;
using Side = Chaos::Side;

class Cut : public ::testing::Test {
 protected:
  /// Runs, and expects a stretch flagged for `kind` within [from_s, to_s], and no explosion: a
  /// graph without contradictions costs up to 0.5 per residual.
  CheckedRun expect_flagged(const std::string& kind, double from_s, double to_s, double most_cost) {
    const CheckedRun spoiled = run_checked(dir_, chaos_.folder());
    bool flagged = false;
    for (const auto& segment : spoiled.metrics.at("segments")) {
      flagged = flagged || (segment.at("kind") == kind && segment.at("to_s") >= from_s - 0.11 &&
                            segment.at("from_s") <= to_s + 0.11);
    }
    EXPECT_TRUE(flagged) << spoiled.metrics.at("segments");
    EXPECT_LE(spoiled.metrics.at("solver").at("cost_per_residual").get<double>(), most_cost);
    EXPECT_LE(spoiled.metrics.at("path_length_m").get<double>(),
              2.0 * clean_run().metrics.at("path_length_m").get<double>());
    return spoiled;
  }

  TempDir dir_;
  Chaos chaos_{testing::simulated_base().sequence, dir_.path() / "spoiled"};
};

TEST_F(Cut, APieceCutOutIsFlagged) {
  chaos_.splice({2.0, 3.5});
  expect_flagged("no_vision", 2.0, 2.1, 5.0);
}

TEST_F(Cut, AnotherRecordingSplicedOnIsFlagged) {
  const auto other = dir_.path() / "other";
  testing::simulate_small(
      other, "scene=corridor duration_s=3 rest_s=0 camera.width=376 camera.height=240");
  chaos_.follow_with(Chaos(other, dir_.path() / "copy"), 3.0);
  expect_flagged("no_vision", 3.0, 3.1, 5.0);
}

TEST_F(Cut, APieceShownBackwardsIsFlaggedAndLeftToTheImu) {
  chaos_.reverse_images({2.0, 4.0});
  const auto spoiled = expect_flagged("conflict", 2.0, 4.0, 0.5);
  EXPECT_LE(spoiled.ate_m(), 0.02 * clean_run().metrics.at("path_length_m").get<double>());
}

}  // namespace
}  // namespace imslam
