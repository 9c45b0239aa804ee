// `imslam finetune` on a few frames of a simulated recording, through the executable.
#include <gtest/gtest.h>

#include "tests/support/finetune_check.hpp"

namespace imslam {
namespace {

namespace fs = std::filesystem;
using testing::expect_same_weights;
using testing::finetune;
using testing::finetune_metrics;
using testing::quoted;
using testing::run_imslam;
using testing::slurp;
using testing::TempDir;

TEST(FinetuneCommand, LeavesNetworksWithModelCardsTwoRunsAndAReport) {
  const TempDir dir;
  const auto result = finetune(dir, ".");
  ASSERT_EQ(result.exit_code, 0) << result.err;
  EXPECT_NE(result.out.find("report: tuned/report.html"), std::string::npos) << result.out;
  const fs::path folder = dir.path() / "tuned";
  for (const char* run : {"zero_shot", "adapted"}) {
    testing::CheckedRun checked;
    testing::expect_complete_run(folder / run, checked);
  }
  const auto metrics = finetune_metrics(folder);
  ASSERT_TRUE(metrics.is_object());
  EXPECT_EQ(metrics.at("epochs").at("done"), 2);
  EXPECT_TRUE(metrics.at("results").at("zero_shot").at("graph_rpe_m").is_number());
  EXPECT_TRUE(metrics.at("results").at("batch_adapted").at("graph_rpe_m").is_number());
  EXPECT_TRUE(metrics.at("results").at("online_adapted").is_null());
  for (const char* curve : {"held_out_loss", "learned_loss", "vo_rpe_m", "graph_rpe_m"}) {
    EXPECT_EQ(metrics.at("curves").at(curve).size(), 3U) << curve;
  }

  const auto given = nlohmann::json::parse(slurp(folder / "zero_shot" / "manifest.json"));
  const std::string data = metrics.at("data_sha256");
  ASSERT_EQ(data.size(), 64U);
  ASSERT_EQ(metrics.at("models").size(), 3U);
  for (const auto& model : metrics.at("models")) {
    const fs::path file = folder / model.at("file").get<std::string>();
    EXPECT_EQ(run_imslam(dir, "model verify " + quoted(file.string())).exit_code, 0);
    EXPECT_NE(model.at("data").get<std::string>().find(data), std::string::npos) << model;
    EXPECT_EQ(model.at("command").get<std::string>().rfind("imslam finetune ", 0), 0U) << model;
    for (const auto& parent : given.at("models")) {
      if (parent.at("name") != model.at("name")) continue;
      EXPECT_EQ(model.at("parent"), parent.at("sha256"));
    }
  }
}

TEST(FinetuneCommand, WhatItFoundOfTheDeviceIsUsedForThatDeviceOnly) {
  const TempDir dir;
  ASSERT_EQ(finetune(dir, ".", "--force").exit_code, 0);  // whether or not so little gains
  const fs::path weights = dir.path() / "tuned" / "weights";
  const auto device = finetune_metrics(dir.path() / "tuned").at("sequences").at(0).at("device");
  const std::string fingerprint = device.at("fingerprint");
  EXPECT_EQ(fingerprint.size(), 16U);
  EXPECT_EQ(device.at("before").at("disparity_offset_px"), 0.0);
  EXPECT_EQ(device.at("after").at("disparity_offset_px"), 0.0);  // the simulator's is exact
  const std::string run = "run " + quoted(testing::simulated_base().sequence.string()) +
                          " --frames 0:10 --front-end learned --imu learned --networks " +
                          quoted(weights.string()) + " --out ";
  const auto own = run_imslam(dir, run + quoted((dir.path() / "own").string()));
  ASSERT_EQ(own.exit_code, 0) << own.err;
  EXPECT_EQ(own.err.find("another device"), std::string::npos) << own.err;
  std::string text = slurp(weights / "device.yaml");
  // Of several devices there is a folder, with a file for each.
  const fs::path devices = dir.path() / "devices";
  fs::create_directories(devices);
  const std::string with_folder =
      "run " + quoted(testing::simulated_base().sequence.string()) +
      " --frames 0:10 --force --set system.device=" + quoted(devices.string()) + " --out " +
      quoted((dir.path() / "folder").string());
  const auto stranger = run_imslam(dir, with_folder);
  ASSERT_EQ(stranger.exit_code, 0) << stranger.err;
  EXPECT_NE((stranger.out + stranger.err).find("knows nothing of this device"), std::string::npos)
      << stranger.err;
  std::ofstream(devices / (fingerprint + ".yaml")) << text;
  const auto known = run_imslam(dir, with_folder);
  EXPECT_EQ((known.out + known.err).find("knows nothing"), std::string::npos) << known.err;
  EXPECT_EQ((known.out + known.err).find("vo.head"), std::string::npos) << known.err;
  std::string of_regression = text;
  const auto head = of_regression.find("geometric");
  ASSERT_NE(head, std::string::npos) << text;
  of_regression.replace(head, 9, "regression");
  std::ofstream(devices / (fingerprint + ".yaml")) << of_regression;
  const auto mixed = run_imslam(dir, with_folder);
  ASSERT_EQ(mixed.exit_code, 0) << mixed.err;
  EXPECT_NE((mixed.out + mixed.err).find("learned with vo.head=regression"), std::string::npos)
      << mixed.err;
  const auto place = text.find(fingerprint);
  ASSERT_NE(place, std::string::npos) << text;
  text.replace(place, 4, "beef");
  std::ofstream(weights / "device.yaml") << text;
  const auto other = run_imslam(dir, run + quoted((dir.path() / "other").string()));
  ASSERT_EQ(other.exit_code, 0) << other.err;
  EXPECT_NE((other.out + other.err).find("another device"), std::string::npos) << other.err;
}

TEST(FinetuneCommand, ItsReportCanBeMadeAnew) {
  const TempDir dir;
  ASSERT_EQ(finetune(dir, ".").exit_code, 0);
  const fs::path folder = dir.path() / "tuned";
  const std::string page = slurp(folder / "report.html");
  const std::string drawing = slurp(folder / "learning.svg");
  EXPECT_NE(page.find("href=\"adapted/report.html\""), std::string::npos);
  EXPECT_NE(page.find("batch-adapted"), std::string::npos);
  EXPECT_NE(drawing.find("learned from"), std::string::npos);
  fs::remove(folder / "report.html");
  fs::remove(folder / "learning.svg");
  EXPECT_EQ(run_imslam(dir, "report " + quoted(folder.string())).exit_code, 0);
  EXPECT_EQ(slurp(folder / "report.html"), page);
  EXPECT_EQ(slurp(folder / "learning.svg"), drawing);
  fs::remove(folder / "metrics.json");
  EXPECT_EQ(run_imslam(dir, "report " + quoted(folder.string())).exit_code, 3);
}

TEST(FinetuneCommand, ThreadsDoNotChangeTheNetworks) {
  const TempDir dir;
  ASSERT_EQ(finetune(dir, "one", "--threads 1").exit_code, 0);
  ASSERT_EQ(finetune(dir, "two", "--threads 2").exit_code, 0);
  expect_same_weights(dir.path() / "one" / "tuned", dir.path() / "two" / "tuned");
}

TEST(FinetuneCommand, AnAbsurdRateHandsTheGivenNetworksBack) {
  const TempDir dir;
  const auto guarded = finetune(dir, "guarded", "--set finetune.rate=1");
  ASSERT_EQ(guarded.exit_code, 0) << guarded.err;
  EXPECT_NE(guarded.out.find("the given networks are the result, unchanged"), std::string::npos)
      << guarded.out;
  const auto metrics = finetune_metrics(dir.path() / "guarded" / "tuned");
  EXPECT_EQ(metrics.at("guard").at("verdict"), "given");
  EXPECT_EQ(metrics.at("results").at("zero_shot"), metrics.at("results").at("batch_adapted"));
  for (const auto& model : metrics.at("models")) {
    if (model.at("parent").get<std::string>().empty()) continue;
    EXPECT_EQ(model.at("sha256"), model.at("parent"));
  }
}

TEST(FinetuneCommand, ForcedItHandsTheBestEpochBack) {
  const TempDir dir;
  const auto forced = finetune(dir, ".", "--force --set finetune.rate=0.02");
  ASSERT_EQ(forced.exit_code, 0) << forced.err;
  const auto metrics = finetune_metrics(dir.path() / "tuned");
  EXPECT_EQ(metrics.at("guard").at("verdict"), "forced");
  EXPECT_EQ(metrics.at("curves").at("epoch").size(), 3U);  // the zero-shot run is the first look
  for (const auto& model : metrics.at("models")) {
    if (model.at("parent").get<std::string>().empty()) continue;
    EXPECT_NE(model.at("sha256"), model.at("parent"));
  }
}

TEST(FinetuneCommand, NamesTheKeyThatIsOutOfBounds) {
  const TempDir dir;
  const auto result = finetune(dir, ".", "--set finetune.rate=2");
  EXPECT_EQ(result.exit_code, 2);
  EXPECT_NE(result.err.find("finetune.rate"), std::string::npos) << result.err;
}

TEST(FinetuneCommand, ResultsThatNoTrainingGoesWithStayUnlessTheyMayGo) {
  const TempDir dir;
  const auto mine = dir.write("tuned/adapted/trajectory.tum", "mine");
  const auto result = finetune(dir, ".");
  EXPECT_EQ(result.exit_code, 6) << result.err;
  EXPECT_NE(result.err.find("--overwrite throws it away"), std::string::npos) << result.err;
  EXPECT_EQ(slurp(mine), "mine");
  EXPECT_EQ(finetune(dir, ".", "--resume").exit_code, 6);  // there is nothing to go on with
  EXPECT_EQ(slurp(mine), "mine");
}

TEST(FinetuneCommand, DoesNotWriteWhereTheGivenWeightsLie) {
  const TempDir dir;
  const fs::path shipped = "imu_net/weights/imu_network.safetensors";
  const fs::path given = dir.write("tuned/weights/imu_network.safetensors", slurp(shipped));
  for (const char* more : {"", " --overwrite"}) {
    const auto result =
        finetune(dir, ".", "--set imu_network.weights=" + quoted(given.string()) + more);
    EXPECT_EQ(result.exit_code, 2) << result.err;
    EXPECT_NE(result.err.find("lies in --out"), std::string::npos) << result.err;
  }
  EXPECT_EQ(slurp(given), slurp(shipped));
}

TEST(FinetuneCommand, RefusesWhatItCannotUse) {
  const TempDir dir;
  const std::string sequence = quoted(testing::simulated_base().sequence.string());
  const auto code = [&](const std::string& arguments) {
    return run_imslam(dir,
                      "finetune " + arguments + " --out " + quoted((dir.path() / "tuned").string()))
        .exit_code;
  };
  EXPECT_EQ(code(""), 2);
  EXPECT_EQ(code(quoted((dir.path() / "nothing").string())), 3);
  EXPECT_EQ(code(sequence + " --set finetune.rat=1"), 2);
  EXPECT_EQ(code(sequence + " --epochs -3"), 2);
  EXPECT_EQ(code(sequence + " --set finetune.held_out=0.9"), 2);
  EXPECT_EQ(code(sequence + " --frames 500:900"), 2);
  EXPECT_EQ(code(sequence + " --resume --overwrite"), 2);
  EXPECT_EQ(code(sequence + " --networks " + quoted((dir.path() / "none").string())), 5);
  EXPECT_EQ(code(sequence + " --front-end klt --imu raw --set finetune.motion_noise=false"), 2);
  EXPECT_FALSE(fs::exists(dir.path() / "tuned" / "log.csv"));
  EXPECT_EQ(run_imslam(dir, "finetune " + sequence + " --out /proc/tuned").exit_code, 6);
}

}  // namespace
}  // namespace imslam
