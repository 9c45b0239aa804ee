// Real logs. Figures are printed; the bounds are what was measured, with room of about a third.
#include <gtest/gtest.h>

#include <cstdio>

#include "slam/training/graph_bias.hpp"
#include "slam/training/inertial_log_file.hpp"
#include "tests/support/test_data.hpp"

namespace imslam::training {
namespace {

using imslam::testing::test_data;

constexpr double kDegrees = 180.0 / M_PI;

OpenScore score_of(const InertialLog& log, const InertialMethod& method, double window_s) {
  OpenIntegrationOptions options;
  options.window_s = window_s;
  const OpenScore s = score(integrate_open(log, method.correct(log).correction, options));
  std::printf("%s, %s, %g s: %zu windows, %.4f deg, %.4f m/s, %.4f m, NEES/9 %.1f\n",
              log.name.c_str(), method.name.c_str(), window_s, s.windows, s.rotation_rms_deg,
              s.velocity_rms, s.position_rms, s.nees);
  return s;
}

struct EurocBound {
  const char* name;
  std::size_t most_jumps;  ///< MH: the tracker's corrections come as steps
  double velocity_sigma;   ///< [m/s]
  double tilt_deg;
  double rotation_deg, velocity, position;  ///< 1 s windows, graph bias
};

constexpr EurocBound kEuroc[] = {
    {"MH04", 8, 0.013, 0.1, 0.025, 0.065, 0.037},
    {"V101", 0, 0.009, 0.25, 0.18, 0.07, 0.037},
    {"V203", 0, 0.013, 0.9, 0.37, 0.135, 0.07},
};

TEST(RealInertialLog, EurocLogsAreReadAndTheGraphKnowsTheirBias) {
  const auto folder = test_data() / "euroc_imu";
  IMSLAM_NEEDS(folder);
  for (const EurocBound& bound : kEuroc) {
    const InertialLogReading reading = read_inertial_log(folder / bound.name);
    EXPECT_LE(reading.log.truth_jumps.size(), bound.most_jumps) << bound.name;
    EXPECT_LT(reading.velocity.sigma, bound.velocity_sigma) << bound.name;
    EXPECT_LT(reading.gravity.tilt * kDegrees, bound.tilt_deg) << bound.name;
    const OpenScore raw = score_of(reading.log, raw_method(), 1.0);
    const OpenScore rest = score_of(reading.log, rest_bias_method(), 1.0);
    const OpenScore graph = score_of(reading.log, graph_bias_method(), 1.0);
    EXPECT_EQ(graph.windows, raw.windows);
    EXPECT_GT(raw.rotation_rms_deg, 4.0) << bound.name;
    EXPECT_LT(rest.rotation_rms_deg, 0.1 * raw.rotation_rms_deg) << bound.name;
    EXPECT_LT(graph.rotation_rms_deg, bound.rotation_deg) << bound.name;
    EXPECT_LT(graph.velocity_rms, bound.velocity) << bound.name;
    EXPECT_LT(graph.position_rms, bound.position) << bound.name;
    EXPECT_LT(graph.position_rms, rest.position_rms) << bound.name;
    EXPECT_LT(graph.nees, 12.0) << bound.name;  // not 1: the datasheet knows no vibration
    EXPECT_GT(raw.nees, 1000.0) << bound.name;
  }
}

TEST(RealInertialLog, KittiLogsAreReadFromPosesOfTheirCamera) {
  const auto folder = test_data() / "kitti_imu";
  const auto extrinsics = test_data() / "kitti_00_excerpt/sequences/00/T_cam0_imu.txt";
  IMSLAM_NEEDS(folder);
  IMSLAM_NEEDS(extrinsics);
  for (const char* name : {"04", "06"}) {
    const InertialLogReading reading = read_inertial_log(folder / name, {extrinsics});
    EXPECT_LT(reading.velocity.sigma, 0.05) << name;
    EXPECT_LT(reading.gravity.tilt * kDegrees, 4.0) << name;
    EXPECT_LE(reading.log.truth_jumps.size(), 20U) << name;
    const OpenScore s = score_of(reading.log, raw_method(), 1.0);
    EXPECT_GT(s.windows, 20U) << name;
    EXPECT_LT(s.rotation_rms_deg, 0.1) << name;
    EXPECT_LT(s.velocity_rms, 0.14) << name;
    EXPECT_LT(s.position_rms, 0.085) << name;
  }
}

TEST(RealInertialLog, TheExcerptOfAEurocFolderIsALog) {
  const auto folder = test_data() / "euroc_mh01_excerpt";
  IMSLAM_NEEDS(folder);
  const InertialLogReading reading = read_inertial_log(folder);
  EXPECT_FALSE(reading.velocity.from_file);
  EXPECT_EQ(reading.log.samples.size(), 2399U);
  EXPECT_DOUBLE_EQ(reading.log.noise.gyro_noise_density, 1.6968e-4);
  EXPECT_LT(score_of(reading.log, graph_bias_method(), 1.0).rotation_rms_deg, 0.02);
}

}  // namespace
}  // namespace imslam::training
