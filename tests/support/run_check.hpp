#pragma once

#include <fcntl.h>
#include <gtest/gtest.h>
#include <sys/file.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <sstream>
#include <string>
#include <vector>

#include "tests/support/command.hpp"

namespace imslam::testing {

/// What a run left behind.
struct CheckedRun {
  CommandResult command;
  nlohmann::json metrics;
  std::string trajectory;  ///< trajectory.tum

  double ate_m(const char* part = "graph") const {
    return metrics.at(part).at("ate_se3_rmse_m").get<double>();
  }
  double error_m(const char* key) const { return metrics.at("graph").at(key).get<double>(); }
  int counter(const char* name) const { return metrics.at("counters").at(name).get<int>(); }
};

/// nullptr stands where a figure is undefined; only these may be.
inline void expect_defined(const nlohmann::json& json, const std::string& path) {
  // The path may be too short for a drift or a metre, or hold no gravity.
  const bool may_be_null =
      path.find("_rel_") != std::string::npos || path.find("rpe_1m") != std::string::npos ||
      path.find("posyaw") != std::string::npos || path.find("sigma") != std::string::npos;
  if (json.is_null()) {
    EXPECT_TRUE(may_be_null) << path << " is null";
  } else if (json.is_number_float()) {
    EXPECT_TRUE(std::isfinite(json.get<double>())) << path;
  } else if (json.is_structured()) {
    for (const auto& [key, value] : json.items()) expect_defined(value, path + "/" + key);
  }
}

/// Eight finite numbers a line, stamps that grow, unit quaternions. Returns the number of poses.
inline int expect_poses(const std::string& text) {
  std::istringstream lines(text);
  double latest = -1e300;
  int poses = 0;
  for (std::string line; std::getline(lines, line);) {
    if (line.empty() || line[0] == '#') continue;
    std::istringstream cells(line);
    double v[8] = {};
    for (double& value : v) cells >> value;
    EXPECT_FALSE(cells.fail()) << line;
    for (const double value : v) EXPECT_TRUE(std::isfinite(value)) << line;
    EXPECT_GT(v[0], latest) << line;
    EXPECT_NEAR(v[4] * v[4] + v[5] * v[5] + v[6] * v[6] + v[7] * v[7], 1.0, 1e-5) << line;
    EXPECT_LT(std::abs(v[1]) + std::abs(v[2]) + std::abs(v[3]), 100.0) << "exploded: " << line;
    latest = v[0];
    ++poses;
  }
  return poses;
}

/// A body that does not move leaves some figures undefined; the others are checked elsewhere.
inline bool stood_still(const nlohmann::json& metrics) {
  return metrics.at("path_length_m").get<double>() < 0.3;
}

/// All files of a run folder, every number in them finite, a pose per frame.
inline void expect_complete_run(const std::filesystem::path& folder, CheckedRun& run) {
  for (const char* name :
       {"trajectory.tum", "trajectory.kitti", "trajectory.csv", "vo_only.tum", "graph.g2o",
        "map.pcd", "metrics.json", "series.json", "config.yaml", "manifest.json", "report.html"}) {
    EXPECT_TRUE(std::filesystem::exists(folder / name)) << name << "\n" << run.command.err;
  }
  run.trajectory = slurp(folder / "trajectory.tum");
  run.metrics = nlohmann::json::parse(slurp(folder / "metrics.json"), nullptr, false);
  ASSERT_TRUE(run.metrics.is_object()) << run.command.err;
  if (!stood_still(run.metrics)) expect_defined(run.metrics, "metrics");
  EXPECT_EQ(expect_poses(run.trajectory), run.metrics.at("frames").get<int>());
  expect_poses(slurp(folder / "vo_only.tum"));
  EXPECT_EQ(run.metrics.at("coverage").get<double>(), 1.0);
  const std::string graph = slurp(folder / "graph.g2o");
  EXPECT_EQ(graph.find("nan"), std::string::npos);
  EXPECT_EQ(graph.find("inf"), std::string::npos);
}

/// metrics.json without what may differ between equal runs: times and memory.
inline std::string reproducible(nlohmann::json metrics) {
  for (const char* key : {"timing_ms", "frames_per_second", "peak_memory_mb", "dataset"}) {
    metrics.erase(key);
  }
  return metrics.dump();
}

/// Runs `dataset` into `dir`/`name` and checks whatever must hold for every run.
inline CheckedRun run_checked(const TempDir& dir,
                              const std::filesystem::path& dataset,
                              const std::string& arguments = "",
                              const std::string& name = "run",
                              int expected_code = 0) {
  CheckedRun run;
  const auto out = dir.path() / name;
  run.command = run_imslam(dir, "run " + quoted(dataset.string()) + " --quiet --out " +
                                    quoted(out.string()) + " " + arguments);
  EXPECT_EQ(run.command.exit_code, expected_code) << run.command.err;
  expect_complete_run(out, run);
  return run;
}

/// An unspoiled sequence and the run on it.
struct Recording {
  std::filesystem::path sequence;
  std::filesystem::path clean_run;
};

/// The unspoiled sequences; `sequence` and `clean_run` are those of the first recording.
struct SimulatedBase {
  std::filesystem::path sequence;
  std::filesystem::path clean_run;
  std::filesystem::path long_sequence;
  std::vector<Recording> recordings;
};

/// `keys`: "key=value key=value".
inline void simulate_small(const std::filesystem::path& out, const std::string& keys) {
  const std::string simulate = quoted(IMSLAM_EXECUTABLE) + " simulate " + quoted(out.string()) +
                               " --set imu.shape_scale=0 antialias=false " + keys +
                               " --quiet >/dev/null 2>&1 </dev/null";
  ASSERT_EQ(std::system(simulate.c_str()), 0);
}

inline void make_base(const SimulatedBase& base) {
  simulate_small(base.long_sequence,
                 "duration_s=18 rest_s=0.5 frame_rate_hz=10 camera.width=320 camera.height=204");
  int seed = 0;
  for (const Recording& each : base.recordings) {
    simulate_small(each.sequence,
                   "duration_s=6 rest_s=0.5 speed=1.5 camera.width=376 camera.height=240 seed=" +
                       std::to_string(++seed));
    const std::string run = quoted(IMSLAM_EXECUTABLE) + " run " + quoted(each.sequence.string()) +
                            " --out " + quoted(each.clean_run.string()) +
                            " --quiet >/dev/null 2>&1 </dev/null";
    ASSERT_EQ(std::system(run.c_str()), 0);
  }
}

/// Made by the executable under test, once per build of it however many processes share it: five
/// recordings of 6 s in a room at 20 Hz, about 5 m each, of other paths and textures; and one of
/// 18 s at 10 Hz. Small images, an IMU with noise and bias but no errors of scale.
inline SimulatedBase simulated_base() {
  namespace fs = std::filesystem;
  const fs::path cache = IMSLAM_TEST_CACHE;
  fs::create_directories(cache);
  const auto age = fs::last_write_time(IMSLAM_EXECUTABLE).time_since_epoch().count();
  const fs::path home = cache / std::to_string(age);
  SimulatedBase base = {home / "sequence1", home / "clean1", home / "long", {}};
  for (const char* number : {"1", "2", "3", "4", "5"}) {
    base.recordings.push_back(
        {home / (std::string("sequence") + number), home / (std::string("clean") + number)});
  }
  const int lock = ::open((cache / "lock").c_str(), O_CREAT | O_RDWR | O_CLOEXEC, 0600);
  ::flock(lock, LOCK_EX);
  if (!fs::exists(base.recordings.back().clean_run / "report.html")) {
    for (const auto& entry : fs::directory_iterator(cache)) {  // of earlier builds
      if (entry.is_directory()) fs::remove_all(entry.path());
    }
    fs::create_directories(home);
    make_base(base);
  }
  ::close(lock);
  return base;
}

/// The run on the unspoiled sequence.
inline const CheckedRun& clean_run() {
  static const CheckedRun run = [] {
    CheckedRun clean;
    expect_complete_run(simulated_base().clean_run, clean);
    return clean;
  }();
  return run;
}

/// The errors to hold: with the scale, and without it, because a common error of the scale would
/// hide what the damage costs.
constexpr std::array<const char*, 2> kErrorKeys = {"ate_se3_rmse_m", "ate_sim3_rmse_m"};

/// Below a millimetre, whatever the length of the path, a ratio would compare luck with luck.
constexpr double kErrorFloor_m = 1e-3;

/// A spoiled run's error over that of the unspoiled one.
inline double error_ratio(const char* key, const CheckedRun& spoiled, const CheckedRun& clean) {
  return spoiled.error_m(key) / std::max(clean.error_m(key), kErrorFloor_m);
}

/// Holds the errors of a spoiled run against `factor` times those of the unspoiled one. The ratios
/// are kept in the test's record.
inline void expect_error_within(double factor, const CheckedRun& spoiled) {
  for (const char* key : kErrorKeys) {
    const double ratio = error_ratio(key, spoiled, clean_run());
    ::testing::Test::RecordProperty(key, std::to_string(ratio));
    EXPECT_LE(ratio, factor) << key << "\n" << spoiled.metrics.at("counters");
  }
}

}  // namespace imslam::testing
