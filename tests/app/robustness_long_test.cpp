// Long outages through the executable: an IMU alone, cuts, standstill; the figures of
// ../shared/reference/reliability.md, M12, M14, M15.
#include <gtest/gtest.h>

#include <algorithm>

#include "tests/support/chaos.hpp"
#include "tests/support/run_check.hpp"
#include "tests/support/tum_file.hpp"

namespace imslam {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;
using testing::Chaos;
using testing::CheckedRun;
using testing::quoted;
using testing::run_checked;
using testing::TempDir;
using Side = Chaos::Side;

std::vector<json> segments(const CheckedRun& run, const std::string& kind) {
  std::vector<json> found;
  for (const json& segment : run.metrics.at("segments")) {
    if (segment.at("kind") == kind) found.push_back(segment);
  }
  return found;
}

/// 18 s at 10 Hz.
class LongOutage : public ::testing::Test {
 protected:
  CheckedRun run(int expected_code = 0) {
    return run_checked(dir_, chaos_.folder(), "", "run", expected_code);
  }
  /// A column of series.json.
  std::vector<double> series(const std::string& name) const {
    const json all = json::parse(testing::slurp(dir_.path() / "run" / "series.json"));
    return all.at("columns").at(name).get<std::vector<double>>();
  }

  TempDir dir_;
  Chaos chaos_{testing::simulated_base().long_sequence, dir_.path() / "spoiled"};
};

TEST_F(LongOutage, TenSecondsUnderALensCapAreDegradedAfterTwo) {  // M12
  chaos_.paint(Side::kBoth, {4.0, 14.0}, [](cv::Mat& image, Random&) { image.setTo(0); });
  const auto spoiled = run();
  const auto degraded = segments(spoiled, "degraded");
  ASSERT_EQ(degraded.size(), 1U) << spoiled.metrics.at("segments");
  EXPECT_NEAR(degraded[0].at("from_s").get<double>(), 6.0, 0.15);
  EXPECT_NEAR(degraded[0].at("to_s").get<double>(), 14.0, 0.15);
  EXPECT_EQ(segments(spoiled, "no_vision").size(), 1U);

  const auto sigma_m = series("position_sigma_m");  // the longer unseen, the less sure
  for (std::size_t frame = 45; frame < 135; frame += 10) {
    EXPECT_GT(sigma_m.at(frame + 10), sigma_m.at(frame)) << frame;
  }
  EXPECT_GT(sigma_m.at(135), 10.0 * sigma_m.at(39));

  const auto inliers = series("inliers");  // vision resumes
  EXPECT_GT(std::count_if(inliers.end() - 35, inliers.end(), [](double n) { return n > 0; }), 33);
}

TEST_F(LongOutage, FiveSecondsThatAreMissingAreFlaggedAndHarmNoOtherPart) {  // M14
  for (const auto& csv : {chaos_.left_csv(), chaos_.right_csv(), chaos_.imu_csv()}) {
    chaos_.cut_lines(csv, {6.0, 11.0});
  }
  const auto spoiled = run();
  EXPECT_FALSE(segments(spoiled, "imu_gap").empty());
  EXPECT_LT(spoiled.metrics.at("graph").at("rpe_frame_rmse_m").get<double>(), 0.5);
}

class Standstill : public ::testing::Test {
 protected:
  fs::path simulate(const std::string& keys) const {
    testing::simulate_small(dir_.path() / "still", keys + " camera.width=320 camera.height=204");
    return dir_.path() / "still";
  }
  /// All poses lie close to the first one.
  void expect_drift_within(double metres, double degrees) const {
    const auto path = testing::read_tum(dir_.path() / "run" / "trajectory.tum");
    for (const auto& pose : path) {
      const lie::SE3d drift = path.front().T.inverse() * pose.T;
      EXPECT_LT(drift.translation().norm(), metres) << pose.time_s;
      EXPECT_LT(drift.rotation().log().norm() * 57.29578, degrees) << pose.time_s;
    }
  }

  TempDir dir_;
};

TEST_F(Standstill, ForAMinuteDriftsLessThanFiveCentimetresAndHalfADegree) {  // M15
  const auto run = run_checked(dir_, simulate("motion=static duration_s=60 frame_rate_hz=4"));
  EXPECT_EQ(run.metrics.at("frames").get<int>(), 241);
  expect_drift_within(0.05, 0.5);
}

TEST_F(Standstill, TurningOnTheSpotStaysOnTheSpot) {  // M15
  const auto run = run_checked(dir_, simulate("motion=pure_rotation duration_s=6"));
  EXPECT_GT(run.counter("imu_samples"), 1000);
  expect_drift_within(0.05, 360.0);
}

TEST_F(Standstill, FreeFallIsSurvived) {  // M15
  const auto falling = simulate("motion=free_fall duration_s=3");
  const auto result = testing::run_imslam(
      dir_, "run " + quoted(falling.string()) + " --out " + quoted((dir_.path() / "run").string()));
  EXPECT_TRUE(result.exit_code == 0 || result.exit_code == 7) << result.exit_code << result.err;
  testing::expect_poses(testing::slurp(dir_.path() / "run" / "trajectory.tum"));
}

}  // namespace
}  // namespace imslam
