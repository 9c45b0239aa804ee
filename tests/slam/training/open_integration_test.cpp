#include "slam/training/open_integration.hpp"

#include <gtest/gtest.h>

#include "slam/base/error.hpp"
#include "slam/base/time.hpp"
#include "tests/slam/training/simulated_log.hpp"

namespace imslam::training {
namespace {

using testing::noisy_sine_log;
using testing::sine_log;

InertialCorrection as_read(const InertialLog& log) {
  InertialCorrection correction;
  correction.corrected.samples = log.samples;
  return correction;
}

OpenIntegrationOptions windows_of(double seconds, double stride_s = 0.0) {
  OpenIntegrationOptions options;
  options.window_s = seconds;
  options.stride_s = stride_s;
  return options;
}

TEST(OpenIntegration, WindowsTileTheLog) {
  const InertialLog log = sine_log(20.0);
  const auto windows = integration_windows(log, windows_of(5.0));
  ASSERT_EQ(windows.size(), 4U);
  for (std::size_t w = 0; w < windows.size(); ++w) {
    EXPECT_EQ(windows[w].first, 100 * w);
    EXPECT_EQ(windows[w].last, 100 * (w + 1));
    EXPECT_DOUBLE_EQ(windows[w].motion.dt_s, 5.0);
  }
  EXPECT_EQ(integration_windows(log, windows_of(5.0, 1.0)).size(), 16U);
  EXPECT_TRUE(integration_windows(log, windows_of(25.0)).empty());
}

TEST(OpenIntegration, ErrorlessReadingsLeadToTheTruth) {
  const InertialLog log = sine_log(20.0, 1000.0);
  const OpenIntegration result = integrate_open(log, as_read(log), windows_of(5.0));
  ASSERT_EQ(result.windows.size(), 4U);
  for (const WindowError& window : result.windows) {
    EXPECT_LT(window.difference.cwiseAbs().maxCoeff(), 1e-4) << window.difference.transpose();
  }
}

TEST(OpenIntegration, DatasheetCovarianceIsThatOfDatasheetNoise) {
  const InertialLog log = noisy_sine_log(400.0, ImuBias(), 7);
  for (const double seconds : {0.5, 2.0}) {
    const OpenScore s = score(integrate_open(log, as_read(log), windows_of(seconds)));
    EXPECT_GE(s.windows, 199U);
    EXPECT_GT(s.nees, s.band_low) << seconds;
    EXPECT_LT(s.nees, s.band_high) << seconds;
    EXPECT_NEAR(s.rotation_nees, 1.0, 0.15) << seconds;
    EXPECT_NEAR(s.inside_95, 0.95, 0.04) << seconds;
  }
}

TEST(OpenIntegration, LikelihoodIsBestWhereTheNoiseIsStatedRight) {
  InertialLog log = noisy_sine_log(200.0, ImuBias(), 8);
  const auto nll = [&](double factor) {
    InertialLog stated = log;
    stated.noise.gyro_noise_density *= factor;
    stated.noise.accel_noise_density *= factor;
    return score(integrate_open(stated, as_read(stated), windows_of(1.0))).negative_log_likelihood;
  };
  EXPECT_LT(nll(1.0), nll(0.7));
  EXPECT_LT(nll(1.0), nll(1.4));
  // 9 dof: twice the spread costs 9 log 2 and saves 3/4 of 9/2.
  EXPECT_NEAR(nll(2.0) - nll(1.0), 9.0 * std::log(2.0) - 0.75 * 4.5, 0.3);
}

TEST(OpenIntegration, SigmaOfTheBiasAtTheStartEntersTheCovariance) {
  const ImuBias bias{{0.01, 0.0, 0.0}, {0.0, 0.1, 0.0}};
  const InertialLog log = noisy_sine_log(20.0, bias, 9);
  InertialCorrection correction = as_read(log);
  const auto plain = integrate_open(log, correction, windows_of(5.0));
  const ImuBias sigma{{0.01, 0.01, 0.01}, {0.1, 0.1, 0.1}};
  correction.corrected.bias_sigma = {{log.truth[0].time_ns, ImuBias()},
                                     {log.truth[150].time_ns, sigma}};
  const auto spread = integrate_open(log, correction, windows_of(5.0));
  ASSERT_EQ(spread.windows.size(), 4U);
  EXPECT_EQ(spread.windows[0].covariance, plain.windows[0].covariance);
  EXPECT_EQ(spread.windows[1].covariance, plain.windows[1].covariance);  // begins before
  EXPECT_EQ(spread.windows[2].difference, plain.windows[2].difference);
  EXPECT_GT(plain.windows[2].nees(), 1000.0);
  EXPECT_LT(spread.windows[2].nees(), 16.9);
  // 0.01 rad/s of bias over 5 s.
  EXPECT_NEAR(std::sqrt(spread.windows[2].covariance.topLeftCorner<3, 3>().trace() / 3.0), 0.05,
              0.01);
}

TEST(OpenIntegration, SubtractsTheBiasAtTheStart) {
  const ImuBias bias{{0.01, -0.02, 0.03}, {0.1, -0.1, 0.2}};
  InertialLog log = sine_log(10.0, 1000.0);
  for (ImuSample& sample : log.samples) {
    sample.angular_velocity += bias.gyro;
    sample.linear_acceleration += bias.accel;
  }
  InertialCorrection correction = as_read(log);
  correction.start_bias = {{log.truth[0].time_ns, bias}};
  for (const WindowError& window : integrate_open(log, correction, windows_of(5.0)).windows) {
    EXPECT_LT(window.difference.cwiseAbs().maxCoeff(), 1e-4);
  }
}

TEST(OpenIntegration, WindowsOverGapsAreCountedAndLeftOut) {
  InertialLog log = sine_log(20.0);
  const auto first = log.samples.begin() + 1300;
  log.samples.erase(first, first + 40);  // 0.2 s from 6.5 s on
  const auto result = integrate_open(log, as_read(log), windows_of(5.0));
  EXPECT_EQ(result.degraded, 1U);
  EXPECT_EQ(result.windows.size(), 3U);
  EXPECT_EQ(score(result).degraded, 1U);
}

TEST(OpenIntegration, NoWindowSpansAJumpOfTheTruth) {
  InertialLog log = sine_log(20.0);
  log.truth_jumps = {150};
  for (const auto& window : integration_windows(log, windows_of(5.0))) {
    EXPECT_TRUE(window.last < 150 || window.first >= 150) << window.first << " " << window.last;
  }
  EXPECT_EQ(integration_windows(log, windows_of(5.0)).size(), 3U);
}

TEST(OpenIntegration, ChiSquaredQuantilesAreThoseOfTables) {
  EXPECT_NEAR(chi_squared_quantile(9.0, 1.644854), 16.919, 0.02);
  EXPECT_NEAR(chi_squared_quantile(100.0, 1.959964), 129.561, 0.02);
  EXPECT_NEAR(chi_squared_quantile(100.0, -1.959964), 74.222, 0.02);
}

TEST(OpenIntegration, RefusesLengthsThatMakeNoSense) {
  EXPECT_THROW(windows_of(0.0).validate(), InputError);
  EXPECT_THROW(windows_of(1.0, -1.0).validate(), InputError);
  EXPECT_EQ(score({}).windows, 0U);
}

}  // namespace
}  // namespace imslam::training
