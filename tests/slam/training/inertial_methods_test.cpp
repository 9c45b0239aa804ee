#include "slam/training/inertial_methods.hpp"

#include <gtest/gtest.h>

#include "slam/base/time.hpp"
#include "slam/training/graph_bias.hpp"
#include "tests/slam/training/simulated_log.hpp"

namespace imslam::training {
namespace {

using testing::noisy_sine_log;

const ImuBias kBias{{0.01, -0.02, 0.03}, {0.05, -0.1, 0.08}};

/// The swaying log with `seconds` of rest before it; the truth begins with the motion.
InertialLog log_after_rest(double seconds) {
  InertialLog log = noisy_sine_log(10.0, kBias, 4);
  Random random(5);
  std::vector<ImuSample> rest;
  for (int i = static_cast<int>(200.0 * seconds); i > 0; --i) {
    ImuSample sample;
    sample.time_ns = log.samples.front().time_ns - i * std::int64_t{5'000'000};
    sample.linear_acceleration = {0.0, 0.0, 9.81};
    rest.push_back(sample);
  }
  imu::testing::disturb(rest, kBias, log.noise, random);
  log.samples.insert(log.samples.begin(), rest.begin(), rest.end());
  return log;
}

TEST(InertialMethods, RawSaysNothingOfTheBias) {
  const InertialLog log = noisy_sine_log(5.0, kBias, 3);
  const auto result = raw_method().correct(log);
  EXPECT_EQ(result.correction.corrected.samples.size(), log.samples.size());
  EXPECT_TRUE(result.correction.corrected.bias_sigma.empty());
  EXPECT_TRUE(result.correction.start_bias.empty());
}

TEST(InertialMethods, RestBiasIsTheMeanRateOfTheStillSecond) {
  const InertialLog log = log_after_rest(2.0);
  const auto result = rest_bias_method().correct(log);
  const auto& corrected = result.correction.corrected;
  ASSERT_EQ(corrected.samples.size(), log.samples.size());
  const Eigen::Vector3d removed =
      log.samples.back().angular_velocity - corrected.samples.back().angular_velocity;
  EXPECT_LT((removed - kBias.gyro).norm(), 1e-3) << removed.transpose();
  EXPECT_EQ(corrected.samples.back().linear_acceleration, log.samples.back().linear_acceleration);
  ASSERT_GE(corrected.bias_sigma.size(), 11U);
  const ImuBias& sigma = corrected.bias_sigma.back().sigma;
  EXPECT_GT(sigma.gyro.minCoeff(), 1e-5);
  EXPECT_LT(sigma.gyro.maxCoeff(), 1e-3);
  EXPECT_GT(sigma.gyro.x(), corrected.bias_sigma.front().sigma.gyro.x());  // it walks away
  EXPECT_EQ(sigma.accel.x(), log.noise.accel_bias_sigma);
  EXPECT_NE(result.remark.find("at rest 0.00 s"), std::string::npos) << result.remark;
}

TEST(InertialMethods, WithoutARestTheReadingsStayAsTheyAre) {
  const InertialLog log = noisy_sine_log(5.0, kBias, 3);
  const auto result = rest_bias_method().correct(log);
  EXPECT_EQ(result.correction.corrected.samples.back().angular_velocity,
            log.samples.back().angular_velocity);
  EXPECT_TRUE(result.correction.corrected.bias_sigma.empty());
  EXPECT_NE(result.remark.find("as raw"), std::string::npos) << result.remark;
}

TEST(InertialMethods, GraphBiasIsTheTrueOne) {
  const InertialLog log = noisy_sine_log(20.0, kBias, 6);
  const GraphBias graph = estimate_graph_bias(log);
  ASSERT_EQ(graph.biases.size(), log.truth.size());
  ASSERT_EQ(graph.bias_sigma.size(), log.truth.size());
  EXPECT_TRUE(graph.report.converged) << graph.report.reason;
  for (std::size_t i = 0; i < graph.biases.size(); i += 50) {
    const ImuBias& found = graph.biases[i].bias;
    EXPECT_LT((found.gyro - kBias.gyro).norm(), 6e-4) << i;
    EXPECT_LT((found.accel - kBias.accel).norm(), 0.04) << i;
    const ImuBias& sigma = graph.bias_sigma[i].sigma;
    EXPECT_LT((found.gyro - kBias.gyro).norm(), 4.0 * sigma.gyro.norm()) << i;
    EXPECT_LT((found.accel - kBias.accel).norm(), 4.0 * sigma.accel.norm()) << i;
  }
}

// The graph must not take the truth's word for a step that no body makes.
TEST(InertialMethods, GraphBiasDoesNotCrossAJumpOfTheTruth) {
  InertialLog log = noisy_sine_log(20.0, kBias, 6);
  const GraphBias smooth = estimate_graph_bias(log);
  for (std::size_t i = 200; i < log.truth.size(); ++i) {
    auto& T = log.truth[i].nav.T_world_body;
    T = lie::SE3d(T.rotation(), T.translation() + Eigen::Vector3d(0.3, 0.0, 0.0));
  }
  log.truth_jumps = {200};
  const GraphBias graph = estimate_graph_bias(log);
  ASSERT_GT(graph.biases.size(), 200U);
  for (const std::size_t i : {199U, 200U}) {
    const Eigen::Vector3d moved = graph.biases[i].bias.accel - smooth.biases[i].bias.accel;
    EXPECT_LT(moved.norm(), 1e-4) << moved.transpose();
  }
}

TEST(InertialMethods, GraphBiasBringsTheWindowsToTheTruth) {
  const InertialLog log = noisy_sine_log(60.0, kBias, 10);
  OpenIntegrationOptions options;
  options.window_s = 2.0;
  const auto rms = [&](const InertialMethod& method) {
    return score(integrate_open(log, method.correct(log).correction, options));
  };
  const OpenScore raw = rms(raw_method());
  const OpenScore graph = rms(graph_bias_method());
  EXPECT_LT(graph.rotation_rms_deg, 0.05 * raw.rotation_rms_deg);
  EXPECT_LT(graph.position_rms, 0.1 * raw.position_rms);
  EXPECT_LT(graph.nees, 1.5);
}

TEST(InertialMethods, ACorrectionOfTheReadingsIsARowToo) {
  const InertialLog log = noisy_sine_log(2.0, kBias, 3);
  const auto method = corrected_method("zero", [](const InertialLog& of) {
    imu::CorrectedSamples corrected{of.samples, {}};
    for (ImuSample& sample : corrected.samples) sample.angular_velocity.setZero();
    return corrected;
  });
  EXPECT_EQ(method.name, "zero");
  EXPECT_TRUE(method.correct(log).correction.corrected.samples.back().angular_velocity.isZero());
}

}  // namespace
}  // namespace imslam::training
