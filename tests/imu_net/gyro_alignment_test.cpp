#include "imu_net/gyro_alignment.hpp"

#include <gtest/gtest.h>

#include "slam/base/error.hpp"
#include "tests/imu_net/synthetic_motion.hpp"
#include "tests/support/numeric_jacobian.hpp"

namespace imslam::imu {
namespace {

using imslam::testing::expect_near;
using testing::disturb;
using testing::SineMotion;
using testing::stamp;

const ImuBias kBias{{-0.003, 0.021, 0.079}, {0.1, 0.1, -0.2}};
constexpr double kVisionStd = 2.5e-4;  // [rad], 0.014 deg as measured on EuRoC

struct World {
  std::vector<ImuSample> samples;
  std::vector<RelativeMotion> vision;
};

/// 20 Hz vision over `seconds`; a camera stamp t was taken at IMU time t + offset. The camera is
/// mounted `mounting` away from where the calibration says.
World make_world(double offset_s,
                 const Eigen::Vector3d& mounting = Eigen::Vector3d::Zero(),
                 double strength = 0.5,
                 double outlier_share = 0.0,
                 std::uint64_t seed = 5,
                 double seconds = 10.0) {
  const SineMotion body(strength);
  Random random(seed);
  World world;
  world.samples = body.samples(0.0, seconds + 0.6, 200.0);
  disturb(world.samples, kBias, ImuNoise{}, random);
  const lie::SO3d M = lie::SO3d::exp(mounting);
  for (double t = 0.3; t + 0.05 < seconds + 0.3; t += 0.05) {
    RelativeMotion motion;
    motion.time0_ns = stamp(t);
    motion.time1_ns = stamp(t + 0.05);
    lie::SO3d R = body.truth(t + offset_s, t + 0.05 + offset_s).dR;
    R = M.inverse() * R * M * lie::SO3d::exp(kVisionStd * random.normal3());
    if (random.chance(outlier_share)) R = R * lie::SO3d::exp(0.05 * random.normal3());
    motion.T_body0_body1 = lie::SE3d(R, Eigen::Vector3d(0.1, 0, 0));
    motion.covariance *= kVisionStd * kVisionStd;
    motion.valid = true;
    world.vision.push_back(motion);
  }
  return world;
}

TEST(AlignGyro, FindsBiasAndTimeOffset) {
  for (const double offset_s : {-0.05, -0.02, -0.003, 0.0, 0.0104, 0.05}) {
    const World world = make_world(offset_s);
    const auto fit = align_gyro(world.vision, world.samples, ImuNoise{});
    ASSERT_TRUE(fit.has_value());
    EXPECT_TRUE(fit->converged);
    EXPECT_TRUE(fit->time_offset_observed);
    EXPECT_NEAR(fit->time_offset_s, offset_s, 1e-3) << offset_s;
    EXPECT_LT((fit->gyro_bias - kBias.gyro).norm(), 2e-3) << offset_s;
    EXPECT_NEAR(fit->residual_scale, 1.0, 0.2);
  }
}

TEST(AlignGyro, FindsTheMountingToo) {
  const Eigen::Vector3d mounting(0.006, -0.01, 0.008);
  const World world = make_world(0.012, mounting);
  GyroAlignmentOptions options;
  options.estimate_rotation = true;
  const auto fit = align_gyro(world.vision, world.samples, ImuNoise{}, options);
  ASSERT_TRUE(fit.has_value());
  EXPECT_NEAR(fit->time_offset_s, 0.012, 1e-3);
  expect_near(fit->rotation_correction, mounting, 2e-3);
  EXPECT_LT((fit->gyro_bias - kBias.gyro).norm(), 2e-3);
}

// Over 60 worlds the squared error in standard deviations must average to the 7 estimated numbers;
// 99.9 % band of the average: 7 +- 3.3 sqrt(14 / 60).
TEST(AlignGyro, CovarianceIsHonest) {
  constexpr int kWorlds = 60;
  GyroAlignmentOptions options;
  options.estimate_rotation = true;
  double sum = 0.0;
  for (int i = 0; i < kWorlds; ++i) {
    const Eigen::Vector3d mounting(0.002, -0.003, 0.001);
    const World world = make_world(0.004, mounting, 0.5, 0.0, 100U + static_cast<unsigned>(i), 5.0);
    const auto fit = align_gyro(world.vision, world.samples, ImuNoise{}, options);
    ASSERT_TRUE(fit.has_value());
    Eigen::Matrix<double, 7, 1> error;
    error << fit->gyro_bias - kBias.gyro, fit->time_offset_s - 0.004,
        fit->rotation_correction - mounting;
    sum += error.dot(fit->covariance.ldlt().solve(error)) / kWorlds;
  }
  EXPECT_GT(sum, 5.4);
  EXPECT_LT(sum, 8.6);
}

TEST(AlignGyro, OutliersOfVisionDoNotPull) {
  const World world = make_world(-0.03, Eigen::Vector3d::Zero(), 0.5, 0.2);
  const auto fit = align_gyro(world.vision, world.samples, ImuNoise{});
  ASSERT_TRUE(fit.has_value());
  EXPECT_NEAR(fit->time_offset_s, -0.03, 2e-3);
  EXPECT_LT((fit->gyro_bias - kBias.gyro).norm(), 3e-3);
  EXPECT_LT(fit->inliers, fit->motions - 20);
}

TEST(AlignGyro, WithoutMotionTheOffsetStaysUnknown) {
  const World world = make_world(0.03, Eigen::Vector3d::Zero(), 0.0);
  const auto fit = align_gyro(world.vision, world.samples, ImuNoise{});
  ASSERT_TRUE(fit.has_value());
  EXPECT_LT((fit->gyro_bias - kBias.gyro).norm(), 2e-3);
  EXPECT_GT(std::sqrt(fit->covariance(3, 3)), 0.02);
  EXPECT_EQ(fit->time_offset_s, 0.0);
  EXPECT_FALSE(fit->time_offset_observed);
}

TEST(AlignGyro, WhatIsNotAskedForStaysZero) {
  const World world = make_world(0.0);
  GyroAlignmentOptions options;
  options.estimate_time_offset = false;
  const auto fit = align_gyro(world.vision, world.samples, ImuNoise{}, options);
  ASSERT_TRUE(fit.has_value());
  EXPECT_EQ(fit->time_offset_s, 0.0);
  EXPECT_EQ(fit->rotation_correction, Eigen::Vector3d::Zero());
  EXPECT_EQ(fit->covariance.bottomRightCorner(4, 4).norm(), 0.0);
}

TEST(AlignGyro, NeedsEnoughMotionsAndSurvivesBrokenOnes) {
  World world = make_world(0.01);
  for (std::size_t i = 0; i < world.vision.size(); i += 3) world.vision[i].valid = false;
  world.vision[1].covariance.setConstant(NAN);
  world.vision[4].time1_ns = world.vision[4].time0_ns;
  EXPECT_NEAR(align_gyro(world.vision, world.samples, ImuNoise{})->time_offset_s, 0.01, 1e-3);
  world.vision.resize(9);
  EXPECT_FALSE(align_gyro(world.vision, world.samples, ImuNoise{}).has_value());
  EXPECT_FALSE(align_gyro({}, world.samples, ImuNoise{}).has_value());
  EXPECT_FALSE(align_gyro(make_world(0.0).vision, {}, ImuNoise{}).has_value());
}

TEST(SearchTimeOffset, ComesWithinOneStep) {
  GyroAlignmentOptions options;
  for (const double offset_s : {-0.09, -0.05, 0.0, 0.033, 0.1}) {
    const World world = make_world(offset_s);
    const auto found = search_time_offset(world.vision, world.samples, ImuNoise{}, options);
    ASSERT_TRUE(found.has_value());
    EXPECT_NEAR(*found, offset_s, options.search_step_s);
  }
}

TEST(GyroAlignmentOptions, RejectASearchWithoutWidth) {
  GyroAlignmentOptions options;
  EXPECT_NO_THROW(options.validate());
  options.max_time_offset_s = 0.0;
  EXPECT_THROW(options.validate(), InputError);
}

}  // namespace
}  // namespace imslam::imu
