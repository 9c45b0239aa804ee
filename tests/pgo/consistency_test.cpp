#include "tools/bench/consistency.hpp"

#include <gtest/gtest.h>

#include <cmath>

namespace imslam::bench {
namespace {

TEST(Consistency, BandOfTheAverageIsThatOfTheChiSquareTable) {
  // reliability.md, computed with scipy.
  EXPECT_NEAR(average_nees_band(3, 50).low, 2.360, 2e-3);
  EXPECT_NEAR(average_nees_band(3, 50).high, 3.716, 2e-3);
  EXPECT_NEAR(average_nees_band(6, 50).low, 5.078, 2e-3);
  EXPECT_NEAR(average_nees_band(6, 100).high, 6.698, 2e-3);
}

constexpr double kStandardErrors = 3.5;  // chance alone goes beyond once in 2000 times

TEST(Consistency, ErrorsOfPoseAndVelocityAreAsLargeAsTheCovariancesSay) {
  for (std::uint64_t seed : {1U, 2U, 3U}) {
    ConsistencyOptions options;
    options.frames = 60;
    options.seed = seed;
    const ConsistencyResult result = study_consistency(options);
    ASSERT_EQ(result.pose_nees.size(), 59U);
    EXPECT_LT(std::abs(result.pose.deviation(6)), kStandardErrors) << "seed " << seed;
    EXPECT_LT(std::abs(result.velocity.deviation(3)), kStandardErrors) << "seed " << seed;
  }
}

TEST(Consistency, MoreNoiseThanTheGraphWasToldIsSeen) {
  ConsistencyOptions options;
  options.frames = 60;
  options.noise = 1.4;
  const ConsistencyResult result = study_consistency(options);
  EXPECT_GT(result.pose.deviation(6), kStandardErrors);
  EXPECT_GT(result.velocity.deviation(3), kStandardErrors);
}

TEST(Consistency, NoiseFreeMeasurementsAreRecovered) {
  ConsistencyOptions options;
  options.runs = 1;
  options.noise = 0.0;
  EXPECT_LT(study_consistency(options).largest_position_error_m, 1e-6);
}

}  // namespace
}  // namespace imslam::bench
