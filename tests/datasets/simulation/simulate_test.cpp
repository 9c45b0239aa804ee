#include "datasets/simulation/simulate.hpp"

#include <gtest/gtest.h>

#include <fstream>
#include <map>
#include <opencv2/core.hpp>
#include <opencv2/imgcodecs.hpp>
#include <sstream>

#include "datasets/simulation/simulator.hpp"
#include "slam/base/config.hpp"
#include "slam/base/error.hpp"
#include "slam/base/file.hpp"
#include "slam/base/parallel.hpp"
#include "slam/base/text.hpp"
#include "tests/support/temp_dir.hpp"

namespace imslam::simulation {
namespace {

namespace fs = std::filesystem;
using testing::TempDir;

SimulationOptions small_options() {
  SimulationOptions options;
  options.textures = "procedural";
  options.duration_s = 1.0;
  options.rest_s = 0.0;
  options.frame_rate_hz = 5.0;
  options.camera.width = 188;
  options.truth_depth = true;
  options.truth_flow = true;
  return options;
}

std::vector<std::string> lines_of(const fs::path& file) {
  std::ifstream stream(file);
  std::vector<std::string> lines;
  for (std::string line; std::getline(stream, line);) lines.push_back(line);
  return lines;
}

/// Relative path -> hash of the content.
std::map<std::string, std::string> contents(const fs::path& folder) {
  std::map<std::string, std::string> hashes;
  for (const auto& entry : fs::recursive_directory_iterator(folder)) {
    if (entry.is_regular_file()) {
      hashes[fs::relative(entry.path(), folder)] = sha256_of_file(entry.path());
    }
  }
  return hashes;
}

TEST(Simulate, WritesTheLayoutOfEuroc) {
  const TempDir dir;
  std::size_t last_done = 0;
  const SimulationSummary summary =
      simulate(small_options(), dir.path() / "out", [&](std::size_t done, std::size_t total) {
        EXPECT_EQ(total, 6U);
        EXPECT_EQ(done, last_done + 1);
        last_done = done;
      });
  EXPECT_EQ(summary.frames, 6U);
  EXPECT_EQ(last_done, 6U);
  EXPECT_EQ(summary.imu_samples, 201U);
  const fs::path mav = dir.path() / "out" / "mav0";
  for (const char* camera : {"cam0", "cam1"}) {
    const auto index = lines_of(mav / camera / "data.csv");
    ASSERT_EQ(index.size(), 7U);
    EXPECT_EQ(index[0], "#timestamp [ns],filename");
    const auto fields = split(index[2], ',');
    EXPECT_EQ(std::string(fields[0]) + ".png", fields[1]);
    const cv::Mat image =
        cv::imread((mav / camera / "data" / std::string(fields[1])).string(), cv::IMREAD_UNCHANGED);
    EXPECT_EQ(image.type(), CV_8UC1);
    EXPECT_EQ(image.size(), cv::Size(188, 120));
    EXPECT_NE(read_file(mav / camera / "sensor.yaml").find("resolution: [188, 120]"),
              std::string::npos);
  }
  const auto imu = lines_of(mav / "imu0" / "data.csv");
  ASSERT_EQ(imu.size(), 202U);
  EXPECT_EQ(split(imu[1], ',').size(), 7U);
  const auto truth = lines_of(mav / "state_groundtruth_estimate0" / "data.csv");
  ASSERT_EQ(truth.size(), 202U);
  EXPECT_EQ(split(truth[0], ',').size(), 17U);
  EXPECT_EQ(split(truth[1], ',').size(), 17U);
  EXPECT_EQ(split(truth[5], ',')[0], split(imu[5], ',')[0]);
}

TEST(Simulate, TruthInTheFileIsTheTruthOfTheMotion) {
  const TempDir dir;
  simulate(small_options(), dir.path() / "out");
  const Simulator simulator(small_options());
  ImuModel imu = simulator.imu();
  const auto truth =
      lines_of(dir.path() / "out" / "mav0" / "state_groundtruth_estimate0" / "data.csv");
  for (std::size_t i = 1; i < truth.size(); ++i) {
    const SimulatedImuSample sample = imu.next();
    std::vector<double> v;
    for (const auto& field : split(truth[i], ',')) v.push_back(*parse_double(field));
    const lie::SE3d& T = sample.truth.T_world_body;
    EXPECT_EQ(Eigen::Vector3d(v[1], v[2], v[3]), T.translation());
    const lie::SO3d R(Eigen::Quaterniond(v[4], v[5], v[6], v[7]));
    EXPECT_LT((R.inverse() * T.rotation()).log().norm(), 1e-12);
    EXPECT_EQ(Eigen::Vector3d(v[8], v[9], v[10]), sample.truth.v_world);
    EXPECT_EQ(Eigen::Vector3d(v[11], v[12], v[13]), sample.bias.gyro);
    EXPECT_EQ(Eigen::Vector3d(v[14], v[15], v[16]), sample.bias.accel);
  }
}

TEST(Simulate, DepthAndFlowReadBackAsDocumented) {
  const TempDir dir;
  simulate(small_options(), dir.path() / "out");
  Simulator simulator(small_options());
  FrameRequest request;
  request.depth = true;
  request.flow_to_s = simulator.frame_time_s(3);
  const SimulatedFrame frame = simulator.render(simulator.frame_time_s(2), request);
  const std::string name = std::to_string(frame.time_ns) + ".png";
  const fs::path mav = dir.path() / "out" / "mav0";
  const cv::Mat depth = cv::imread((mav / "depth0" / "data" / name).string(), cv::IMREAD_UNCHANGED);
  ASSERT_EQ(depth.type(), CV_8UC4);
  const cv::Mat metres(depth.rows, depth.cols, CV_32F, depth.data);
  EXPECT_EQ(metres.at<float>(60, 90), frame.depth[60 * 188 + 90]);
  const cv::Mat flow = cv::imread((mav / "flow0" / "data" / name).string(), cv::IMREAD_UNCHANGED);
  ASSERT_EQ(flow.type(), CV_16UC3);
  const auto coded = flow.at<cv::Vec3w>(60, 90);
  const std::size_t at = 60 * 188 + 90;
  EXPECT_EQ(coded[0], frame.flow_valid[at]);
  EXPECT_NEAR((coded[1] - 32768.0) / 64.0, frame.flow[2 * at + 1], 0.5 / 64);
  EXPECT_NEAR((coded[2] - 32768.0) / 64.0, frame.flow[2 * at], 0.5 / 64);
}

TEST(Simulate, EqualOptionsGiveEqualFilesForOneAndTwoThreads) {
  const TempDir dir;
  const int threads = thread_count();
  set_thread_count(1);
  simulate(small_options(), dir.path() / "one");
  set_thread_count(2);
  simulate(small_options(), dir.path() / "two");
  set_thread_count(threads);
  EXPECT_EQ(contents(dir.path() / "one"), contents(dir.path() / "two"));
}

TEST(Simulate, TheSavedOptionsRepeatTheSequence) {
  const TempDir dir;
  SimulationOptions options = small_options();
  options.seed = 77;
  options.imu.grade = "mems";
  simulate(options, dir.path() / "out");
  SimulationOptions loaded;
  Config config;
  config.section("simulation", loaded);
  config.load_file(dir.path() / "out" / "simulation.yaml");
  EXPECT_EQ(loaded.seed, 77);
  simulate(loaded, dir.path() / "again");
  EXPECT_EQ(contents(dir.path() / "out"), contents(dir.path() / "again"));
}

TEST(Simulate, RefusesAFolderThatIsNotEmptyUnlessForced) {
  const TempDir dir;
  dir.write("out/mav0/cam0/data/old.png", "old");
  dir.write("out/notes.txt", "mine");
  try {
    simulate(small_options(), dir.path() / "out");
    FAIL() << "expected InputError";
  } catch (const InputError& error) {
    EXPECT_EQ(error.code(), ExitCode::kOutput);
    EXPECT_NE(std::string(error.what()).find("is not empty"), std::string::npos);
  }
  dir.write("out/simulation.yaml", "");
  SimulationOptions options = small_options();
  options.force = true;
  simulate(options, dir.path() / "out");
  EXPECT_FALSE(fs::exists(dir.path() / "out/mav0/cam0/data/old.png"));
  EXPECT_TRUE(fs::exists(dir.path() / "out/notes.txt"));
}

TEST(Simulate, ForceReplacesNothingThatNoSimulationWrote) {
  const TempDir dir;
  dir.write("out/mav0/cam0/data/real.png", "precious");
  const auto before = contents(dir.path());
  SimulationOptions options = small_options();
  options.force = true;
  try {
    simulate(options, dir.path() / "out");
    FAIL() << "expected InputError";
  } catch (const InputError& error) {
    EXPECT_EQ(error.code(), ExitCode::kOutput);
    EXPECT_NE(std::string(error.what()).find("no earlier simulation"), std::string::npos);
  }
  EXPECT_EQ(contents(dir.path()), before);
}

TEST(Simulate, RefusesAFolderThatCannotBeMade) {
  const TempDir dir;
  dir.write("file", "x");
  EXPECT_THROW(simulate(small_options(), dir.path() / "file"), InputError);
  EXPECT_THROW(simulate(small_options(), dir.path() / "file" / "below"), InputError);
}

TEST(Simulate, LosesTheShareOfImagesThatWasAskedFor) {
  const TempDir dir;
  SimulationOptions options = small_options();
  options.duration_s = 8.0;
  options.frame_rate_hz = 20.0;
  options.camera.width = 40;
  options.truth_depth = false;
  options.truth_flow = false;
  options.drop_right_percent = 30.0;
  simulate(options, dir.path() / "out");
  const fs::path mav = dir.path() / "out" / "mav0";
  EXPECT_EQ(lines_of(mav / "cam0" / "data.csv").size(), 162U);
  EXPECT_NEAR(static_cast<double>(lines_of(mav / "cam1" / "data.csv").size()), 1 + 0.7 * 161, 20.0);
}

TEST(Simulate, TheCameraClockLagsByTheDelayThatWasAskedFor) {
  SimulationOptions options = small_options();
  options.imu.camera_delay_s = 0.012;
  Simulator simulator(options);
  EXPECT_EQ(simulator.render(0.4).time_ns, simulator.stamp_ns(0.4) - 12'000'000);
}

}  // namespace
}  // namespace imslam::simulation
