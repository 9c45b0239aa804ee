#pragma once

#include <gtest/gtest.h>

#include <filesystem>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "tests/support/run_check.hpp"

namespace imslam::testing {

/// As few frames, steps and motions as can teach.
inline constexpr const char* kTinyFinetune =
    " --frames 0:14 --set finetune.epochs=2 finetune.steps_per_epoch=2 finetune.edges=2 "
    "finetune.stretch=3 finetune.imu_crop_s=5 finetune.matcher=heads ";

/// `imslam finetune` on the base recording, within `dir` so that equal arguments are equal
/// commands; `place` is relative to it.
inline CommandResult finetune(const TempDir& dir,
                              const std::string& place,
                              const std::string& more = "",
                              const std::string& before = "") {
  std::filesystem::create_directories(dir.path() / place);
  const std::string sequence =
      std::filesystem::absolute(simulated_base().sequence).lexically_normal().string();
  return run_imslam(dir, "finetune " + quoted(sequence) + kTinyFinetune + "--out tuned " + more,
                    "cd " + quoted((dir.path() / place).string()) + " && " + before);
}

/// Files of two folders, byte by byte.
inline void expect_same_files(const std::filesystem::path& a,
                              const std::filesystem::path& b,
                              const std::vector<std::string>& names) {
  for (const std::string& name : names) {
    const std::string bytes = slurp(a / name);
    EXPECT_FALSE(bytes.empty()) << a / name;
    EXPECT_TRUE(bytes == slurp(b / name)) << name << " differs";
  }
}

/// What every finished fine-tuning leaves, whatever learns.
inline const std::vector<std::string> kLearnedFiles = {
    "before.safetensors", "networks.safetensors", "weights/motion_noise.safetensors",
    "weights/imu_network.safetensors", "log.csv"};

/// All weights of a finished fine-tuning that lets the matcher learn.
inline void expect_same_weights(const std::filesystem::path& a, const std::filesystem::path& b) {
  expect_same_files(a, b, kLearnedFiles);
  expect_same_files(a, b, {"weights/match_network.safetensors", "weights/device.yaml"});
}

inline nlohmann::json finetune_metrics(const std::filesystem::path& folder) {
  return nlohmann::json::parse(slurp(folder / "metrics.json"), nullptr, false);
}

}  // namespace imslam::testing
