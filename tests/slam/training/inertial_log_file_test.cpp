#include "slam/training/inertial_log_file.hpp"

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <string>

#include "slam/base/time.hpp"
#include "tests/datasets/expect_error.hpp"
#include "tests/imu_net/synthetic_motion.hpp"
#include "tests/support/temp_dir.hpp"

namespace imslam::training {
namespace {

using imslam::testing::expect_input_error;
using imslam::testing::TempDir;
using imu::testing::SineMotion;
using imu::testing::stamp;

constexpr double kDuration_s = 30.0;
const SineMotion kMotion;

std::string imu_csv(double rate_hz, std::int64_t origin_ns, const std::string& comment = "") {
  std::string text = "#timestamp [ns],w_x,w_y,w_z [rad/s],a_x,a_y,a_z [m/s^2]" + comment + "\n";
  for (const ImuSample& s : kMotion.samples(0.0, kDuration_s, rate_hz)) {
    const auto& w = s.angular_velocity;
    const auto& a = s.linear_acceleration;
    text += fmt::format("{},{},{},{},{},{},{}\n", s.time_ns - stamp(0.0) + origin_ns, w.x(), w.y(),
                        w.z(), a.x(), a.y(), a.z());
  }
  return text;
}

/// Rows "stamp px py pz qx qy qz qw" of the body in a world turned by `R_truth_world`.
std::string tum(double rate_hz, const lie::SO3d& R_truth_world = {}, double jump_m = 0.0) {
  std::string text = "# T_world_body\n";
  for (int i = 0; i <= static_cast<int>(kDuration_s * rate_hz); ++i) {
    const double t = i / rate_hz;
    lie::SE3d T = lie::SE3d(R_truth_world, {0, 0, 0}) * kMotion.state(t).T_world_body;
    if (t > 15.1) T = lie::SE3d(lie::SO3d(), {jump_m, 0, 0}) * T;
    const std::int64_t time_ns = stamp(t);
    const auto& q = T.rotation().quaternion();
    const auto& p = T.translation();
    text += fmt::format("{}.{:09} {} {} {} {} {} {} {}\n", time_ns / 1'000'000'000,
                        time_ns % 1'000'000'000, p.x(), p.y(), p.z(), q.x(), q.y(), q.z(), q.w());
  }
  return text;
}

double worst_velocity_error(const InertialLog& log, const lie::SO3d& R_truth_world = {}) {
  double worst = 0.0;
  for (const auto& state : log.truth) {
    const auto nav = kMotion.state(to_seconds(state.time_ns - stamp(0.0)));
    worst = std::max(worst, (state.nav.v_world - R_truth_world * nav.v_world).norm());
  }
  return worst;
}

TEST(InertialLogFile, ReadsReadingsAndTumTruthAndFitsVelocities) {
  const TempDir dir;
  dir.write("run_imu.csv", imu_csv(200.0, stamp(0.0)));
  dir.write("run_truth.tum", tum(20.0));
  const auto reading = read_inertial_log(dir.path() / "run");
  const InertialLog& log = reading.log;
  EXPECT_EQ(log.name, "run");
  EXPECT_EQ(log.samples.size(), 6001U);
  EXPECT_GT(log.truth.size(), 590U);
  EXPECT_TRUE(log.truth_jumps.empty());
  EXPECT_FALSE(reading.velocity.from_file);
  EXPECT_LT(worst_velocity_error(log), 0.01);
  // The stated noise is an upper bound of the real one, and a close one.
  EXPECT_LT(reading.velocity.sigma, 0.01);
  EXPECT_LT(reading.gravity.tilt, 1e-3);
  EXPECT_DOUBLE_EQ(log.noise.gyro_noise_density, ImuNoise().gyro_noise_density);
}

TEST(InertialLogFile, FindsTheGravityOfAWorldThatIsOffLevel) {
  const TempDir dir;
  const lie::SO3d R = lie::SO3d::exp({0.01, -0.005, 0.0});
  dir.write("run_imu.csv", imu_csv(200.0, stamp(0.0)));
  dir.write("run_truth.tum", tum(20.0, R));
  const auto reading = read_inertial_log(dir.path() / "run");
  EXPECT_LT((reading.log.gravity_world - R * imu::testing::kGravity).norm(), 5e-3);
  EXPECT_NEAR(reading.gravity.tilt, Eigen::Vector2d(0.01, 0.005).norm(), 5e-4);
  EXPECT_LT(worst_velocity_error(reading.log, R), 0.01);
}

TEST(InertialLogFile, FindsTheJumpOfATruth) {
  const TempDir dir;
  dir.write("run_imu.csv", imu_csv(200.0, stamp(0.0)));
  dir.write("run_truth.tum", tum(100.0, {}, 0.1));
  const auto log = read_inertial_log(dir.path() / "run").log;
  ASSERT_EQ(log.truth_jumps.size(), 1U);
  const double at_s = to_seconds(log.truth[log.truth_jumps[0]].time_ns - stamp(0.0));
  EXPECT_NEAR(at_s, 15.1, 0.3);
  EXPECT_GT(at_s, 15.1);
  EXPECT_LT(worst_velocity_error(log), 0.01);
}

TEST(InertialLogFile, CarriesKittiCameraPosesToTheImu) {
  const TempDir dir;
  // 10 samples per interval of 0.1 s; the camera is 1 m ahead of the IMU and looks forward.
  dir.write("07_imu.csv", imu_csv(100.0, 0, "  (10 samples, nominal interval 0.1 s)"));
  dir.write("T_cam0_imu.txt", "0 -1 0 0\n0 0 -1 0.2\n1 0 0 -1\n0 0 0 1\n");
  Eigen::Matrix4d M;
  M << 0, -1, 0, 0, 0, 0, -1, 0.2, 1, 0, 0, -1, 0, 0, 0, 1;
  const lie::SE3d T_imu_cam = lie::SE3d::from_matrix(M).inverse();
  Eigen::Matrix3d R_cam0_world;
  R_cam0_world << 0, -1, 0, 0, 0, -1, 1, 0, 0;
  std::string poses;
  for (int i = 0; i <= 300; ++i) {
    const auto T_world_imu = kMotion.state(0.1 * i).T_world_body;
    const lie::SE3d T =
        lie::SE3d(lie::SO3d::from_matrix(R_cam0_world), {0, 0, 0}) * T_world_imu * T_imu_cam;
    const Eigen::Matrix4d N = T.matrix();
    for (int k = 0; k < 12; ++k) poses += fmt::format("{} ", N(k / 4, k % 4));
    poses += "\n";
  }
  dir.write("07_poses.txt", poses);
  const auto log = read_inertial_log(dir.path() / "07").log;
  ASSERT_GT(log.truth.size(), 280U);
  for (const auto& state : log.truth) {
    const auto nav = kMotion.state(to_seconds(state.time_ns));
    const lie::SE3d error = nav.T_world_body.inverse() * state.nav.T_world_body;
    EXPECT_LT(error.log().norm(), 1e-9);
  }
  EXPECT_LT((log.gravity_world - imu::testing::kGravity).norm(), 0.05);
  EXPECT_DOUBLE_EQ(log.noise.rate_hz, 100.0);
}

std::string euroc_truth(bool velocities) {
  std::string text = "#timestamp, p, q, v\n";
  for (int i = -10; i <= 600; ++i) {
    const auto nav = kMotion.state(0.05 * i);
    const auto& q = nav.T_world_body.rotation().quaternion();
    const auto& p = nav.T_world_body.translation();
    text += fmt::format("{},{},{},{},{},{},{},{}", stamp(0.05 * i), p.x(), p.y(), p.z(), q.w(),
                        q.x(), q.y(), q.z());
    if (velocities) {
      text +=
          fmt::format(",{},{},{},0,0,0,0,0,0", nav.v_world.x(), nav.v_world.y(), nav.v_world.z());
    }
    text += "\n";
  }
  return text;
}

TEST(InertialLogFile, TakesVelocitiesAndNoiseOfAEurocFolder) {
  const TempDir dir;
  dir.write("room/mav0/imu0/data.csv", imu_csv(200.0, stamp(0.0)));
  dir.write("room/mav0/imu0/sensor.yaml",
            "T_BS:\n  cols: 4\n  rows: 4\n  data: [1,0,0,0, 0,1,0,0, 0,0,1,0, 0,0,0,1]\n"
            "rate_hz: 200\ngyroscope_noise_density: 3.0e-4\ngyroscope_random_walk: 2.0e-5\n"
            "accelerometer_noise_density: 2.0e-3\naccelerometer_random_walk: 3.0e-3\n");
  dir.write("room/mav0/state_groundtruth_estimate0/data.csv", euroc_truth(true));
  const auto stated = read_inertial_log(dir.path() / "room/");
  EXPECT_EQ(stated.log.name, "room");
  EXPECT_TRUE(stated.velocity.from_file);
  EXPECT_EQ(stated.log.truth.size(), 601U);  // those before the first sample are left out
  EXPECT_EQ(stated.log.truth.front().time_ns, stamp(0.0));
  EXPECT_LT(worst_velocity_error(stated.log), 1e-5);  // stamps are read to 240 ns
  EXPECT_DOUBLE_EQ(stated.log.noise.gyro_noise_density, 3.0e-4);
  dir.write("room/mav0/state_groundtruth_estimate0/data.csv", euroc_truth(false));
  const auto fitted = read_inertial_log(dir.path() / "room/mav0");
  EXPECT_FALSE(fitted.velocity.from_file);
  EXPECT_EQ(fitted.log.name, "room");
  EXPECT_LT(worst_velocity_error(fitted.log), 0.01);
}

TEST(InertialLogFile, NamesFileAndLineOfWhatIsWrong) {
  const TempDir dir;
  const auto read = [&] { read_inertial_log(dir.path() / "run"); };
  expect_input_error(read, ExitCode::kData, {"run", "mav0/imu0", "run_imu.csv"});
  dir.write("run_imu.csv", imu_csv(200.0, stamp(0.0)));
  expect_input_error(read, ExitCode::kData, {"run_imu.csv", "run_truth.tum", "run_poses.txt"});
  dir.write("run_truth.tum", "1400000000.0 0 0 0 0 0 0 1\n1400000001.0 0 0\n");
  expect_input_error(read, ExitCode::kData, {"run_truth.tum:2"});
  dir.write("run_truth.tum", "1400000001.0 0 0 0 0 0 0 1\n1400000001.0 0 0 0 0 0 0 1\n");
  expect_input_error(read, ExitCode::kData, {"run_truth.tum", "pose 2", "sort"});
  dir.write("run_truth.tum", "17.0 0 0 0 0 0 0 1\n18.0 0 0 0 0 0 0 1\n");
  expect_input_error(read, ExitCode::kData, {"one clock"});
  dir.write("run_truth.tum", "1400000001.0 0 0 0 0 0 0 1\n1400000009.0 0 0 0 0 0 0 1\n");
  expect_input_error(read, ExitCode::kData, {"gaps"});
  dir.write("run_imu.csv", "#\n1,0,0,0,0,0,9.81\n2,0,0,zero,0,0,9.81\n");
  expect_input_error(read, ExitCode::kData, {"run_imu.csv:3"});
}

TEST(InertialLogFile, NamesWhatKittiPosesLack) {
  const TempDir dir;
  const auto read = [&] { read_inertial_log(dir.path() / "07"); };
  dir.write("07_imu.csv", imu_csv(100.0, 0));
  dir.write("07_poses.txt", "1 0 0 0 0 1 0 0 0 0 1 0\n1 0 0 0 0 1 0 0 0 0 1 0\n");
  expect_input_error(read, ExitCode::kCalibration, {"07_poses.txt", "T_cam0_imu.txt"});
  dir.write("T_cam0_imu.txt", "0 -1 0 0\n0 0 -1 0\n1 0 0 0\n0 0 0 1\n");
  expect_input_error(read, ExitCode::kData, {"07_imu.csv", "nominal interval"});
  dir.write("07_times.txt", "0.0\n0.1\n0.2\n");
  expect_input_error(read, ExitCode::kData, {"07_times.txt", "found 3 for 2"});
  dir.write("07_imu.csv", imu_csv(100.0, 0, " nominal interval many s"));
  std::filesystem::remove(dir.path() / "07_times.txt");
  expect_input_error(read, ExitCode::kData, {"07_imu.csv:1", "0.1037"});
}

}  // namespace
}  // namespace imslam::training
