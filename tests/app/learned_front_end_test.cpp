// `imslam run --front-end learned` with the shipped weights, and `imslam train vo`.
#include <gtest/gtest.h>

#include "tests/support/chaos.hpp"
#include "tests/support/run_check.hpp"
#include "tools/bench/sequence_conditions.hpp"

namespace imslam {
namespace {

namespace fs = std::filesystem;
using testing::quoted;
using testing::reproducible;
using testing::run_checked;
using testing::run_imslam;
using testing::slurp;
using testing::TempDir;

constexpr const char* kLearned = "--front-end learned --imu off";

class LearnedFrontEnd : public ::testing::Test {
 protected:
  /// What both front ends make of the base recording's first frames under a condition.
  std::pair<testing::CheckedRun, testing::CheckedRun> spoiled(const std::string& name,
                                                              int severity) {
    const fs::path folder = dir_.path() / "spoiled";
    bench::SequenceCondition{name}.spoil(base_, folder, severity);
    return {run_checked(dir_, folder, "--front-end klt --imu off", "klt"),
            run_checked(dir_, folder, kLearned, "learned")};
  }

  TempDir dir_;
  fs::path base_ = testing::simulated_base().sequence;
};

TEST_F(LearnedFrontEnd, IsAsAccurateAsTheClassicalOneOnCleanImages) {
  const auto klt = run_checked(dir_, base_, "--front-end klt --imu off", "klt");
  const auto learned = run_checked(dir_, base_, kLearned, "learned");
  EXPECT_EQ(learned.counter("vo_failures"), 0);
  EXPECT_LT(learned.ate_m("vo"), std::max(1.2 * klt.ate_m("vo"), 0.003));
}

TEST_F(LearnedFrontEnd, SeesThroughMotionBlurThatBlindsTheClassicalOne) {
  const auto [klt, learned] = spoiled("motion_blur", 5);
  EXPECT_EQ(learned.counter("vo_failures"), 0);
  EXPECT_LT(learned.ate_m("vo"), 0.5 * klt.ate_m("vo"));
}

TEST_F(LearnedFrontEnd, ThreadsDoNotChangeTheResult) {
  const std::string few = std::string("--frames 0:25 ") + kLearned;
  const auto once = run_checked(dir_, base_, few + " --threads 1", "one");
  const auto again = run_checked(dir_, base_, few + " --threads 2", "two");
  EXPECT_EQ(once.trajectory, again.trajectory);
}

TEST_F(LearnedFrontEnd, TheManifestNamesTheModel) {
  run_checked(dir_, base_, std::string("--frames 0:10 ") + kLearned, "run");
  const auto manifest = nlohmann::json::parse(slurp(dir_.path() / "run" / "manifest.json"));
  ASSERT_EQ(manifest.at("models").size(), 1U);
  EXPECT_EQ(manifest.at("models")[0].at("sha256").get<std::string>().size(), 64U);
}

TEST_F(LearnedFrontEnd, ADamagedWeightFileIsRefused) {
  const auto file = dir_.write("bad.safetensors", "no weights");
  const auto result =
      run_imslam(dir_, "run " + quoted(base_.string()) + " --front-end learned --set " +
                           quoted("vo.learned.weights=" + file.string()) + " --out " +
                           quoted((dir_.path() / "run").string()));
  EXPECT_EQ(result.exit_code, 5) << result.err;
  EXPECT_NE(result.err.find("bad.safetensors"), std::string::npos) << result.err;
}

TEST(TrainCommand, TrainsStopsAndGoesOn) {
  const TempDir dir;
  const std::string small =
      "train vo --set batch=2 --set validation_samples=2 --set validation_every=2 "
      "--set triplets.textures=procedural --set triplets.texture_count=6 "
      "--set triplets.scene.width=128 --set triplets.scene.height=96 "
      "--set triplets.scene.most_disparity=40 --set triplets.scene.rotation_flow=20 "
      "--set triplets.scene.parallax_flow=20 --set steps=2 --set warm_up=1 --out " +
      quoted((dir.path() / "t").string());
  const auto first = run_imslam(dir, small);
  EXPECT_EQ(first.exit_code, 0) << first.err;
  const fs::path weights = dir.path() / "t" / "match_network.safetensors";
  EXPECT_EQ(run_imslam(dir, "model verify " + quoted(weights.string())).exit_code, 0);
  EXPECT_EQ(run_imslam(dir, small).exit_code, 6);  // holds a training
  EXPECT_EQ(run_imslam(dir, small + " --resume").exit_code, 0);
  EXPECT_EQ(run_imslam(dir, small + " --resume --set rate=0.1").exit_code, 5);  // another one
  EXPECT_EQ(run_imslam(dir, "train vo --set stepps=3").exit_code, 2);
  EXPECT_EQ(run_imslam(dir, "train vo --set steps=2").exit_code, 2);  // less than the warm-up
}

}  // namespace
}  // namespace imslam
