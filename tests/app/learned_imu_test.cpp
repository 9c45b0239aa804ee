// `imslam run --imu learned` and `imslam imu` with the shipped weights, and `imslam train imu`.
#include <gtest/gtest.h>

#include "tests/support/run_check.hpp"
#include "tests/support/test_data.hpp"

namespace imslam {
namespace {

namespace fs = std::filesystem;
using testing::quoted;
using testing::run_checked;
using testing::run_imslam;
using testing::slurp;
using testing::TempDir;

class LearnedImu : public ::testing::Test {
 protected:
  TempDir dir_;
  fs::path base_ = testing::simulated_base().sequence;
};

// Not better: this simulated sensor is as good as its datasheet (README, "The IMU network").
TEST_F(LearnedImu, StaysInTheRangeOfTheRawOne) {
  const auto raw = run_checked(dir_, base_, "--imu raw", "raw");
  const auto learned = run_checked(dir_, base_, "--imu learned", "learned");
  EXPECT_LT(learned.ate_m("graph"), std::max(2.0 * raw.ate_m("graph"), 0.005));
}

TEST_F(LearnedImu, ThreadsDoNotChangeTheResult) {
  const std::string few = "--frames 0:60 --imu learned";
  const auto once = run_checked(dir_, base_, few + " --threads 1", "one");
  const auto again = run_checked(dir_, base_, few + " --threads 2", "two");
  EXPECT_EQ(once.trajectory, again.trajectory);
}

TEST_F(LearnedImu, TheManifestNamesTheModel) {
  run_checked(dir_, base_, "--frames 0:30 --imu learned", "run");
  const auto manifest = nlohmann::json::parse(slurp(dir_.path() / "run" / "manifest.json"));
  ASSERT_EQ(manifest.at("models").size(), 1U);
  EXPECT_EQ(manifest.at("models")[0].at("name"), "imu_network");
}

TEST_F(LearnedImu, WeightsOfAnotherNetworkAreRefused) {
  const auto result = run_imslam(
      dir_, "run " + quoted(base_.string()) +
                " --imu learned --set imu_network.weights=vo_net/weights/pose_head.safetensors"
                " --out " +
                quoted((dir_.path() / "run").string()));
  EXPECT_EQ(result.exit_code, 5) << result.err;
  EXPECT_NE(result.err.find("pose_head"), std::string::npos) << result.err;
}

// Bounds: what was measured on logs that neither training nor its choices have seen, with room.
TEST_F(LearnedImu, OnRealLogsItIsManyTimesBetterThanRaw) {
  const fs::path folder = testing::test_data() / "euroc_imu";
  IMSLAM_NEEDS(folder);
  const auto result = run_imslam(dir_, "imu " + quoted((folder / "MH04").string()) +
                                           " --windows 5 --out " + quoted(dir_.path().string()));
  ASSERT_EQ(result.exit_code, 0) << result.err;
  const auto json = nlohmann::json::parse(slurp(dir_.path() / "imu.json"));
  double raw = 0.0, network = 0.0;
  for (const auto& row : json[0].at("rows")) {
    if (row.at("method") == "raw") raw = row.at("rotation_rms_deg");
    if (row.at("method") == "network") network = row.at("rotation_rms_deg");
  }
  EXPECT_GT(raw, 15.0);
  EXPECT_GT(network, 0.0);
  EXPECT_LT(network, raw / 8.0);
}

}  // namespace
}  // namespace imslam
