#include "imu_net/static_detector.hpp"

#include <gtest/gtest.h>

#include "imu_net/gravity_alignment.hpp"
#include "slam/base/error.hpp"
#include "tests/imu_net/synthetic_motion.hpp"
#include "tests/support/numeric_jacobian.hpp"

namespace imslam::imu {
namespace {

using imslam::testing::expect_near;
using testing::disturb;
using testing::kGravity;
using testing::SineMotion;
using testing::stamp;

const ImuBias kBias{{-0.003, 0.021, 0.079}, {0.02, -0.03, 0.04}};
const lie::SO3d kAttitude = lie::SO3d::exp({0.2, -1.2, 0.7});

/// A body at rest, with the datasheet's noise and a vibration that is faster than the bins.
std::vector<ImuSample> resting(double vibration = 0.0, const ImuBias& bias = kBias) {
  std::vector<ImuSample> samples;
  for (int i = 0; i <= 400; ++i) {
    const double shake = vibration * std::sin(2.0 * M_PI * 37.0 * 0.005 * i);
    ImuSample sample;
    sample.time_ns = stamp(0.005 * i);
    sample.angular_velocity = Eigen::Vector3d::Constant(0.1 * shake);
    sample.linear_acceleration =
        kAttitude.inverse() * (-kGravity) + shake * Eigen::Vector3d::Ones();
    samples.push_back(sample);
  }
  Random random(3);
  disturb(samples, bias, ImuNoise{}, random);
  return samples;
}

bool is_still(const std::vector<ImuSample>& samples) {
  return assess_stillness(samples, stamp(0.0), stamp(1.0), ImuNoise{}).still;
}

TEST(AssessStillness, RestIsStillAlsoUnderVibration) {
  EXPECT_TRUE(is_still(resting()));
  EXPECT_TRUE(is_still(resting(0.5)));
}

TEST(AssessStillness, MotionIsNotStill) {
  for (const double strength : {0.05, 0.3, 1.0}) {
    EXPECT_FALSE(is_still(SineMotion(strength).samples(0.0, 2.0, 200.0))) << strength;
  }
}

TEST(AssessStillness, SteadyTurningIsNotStill) {
  EXPECT_FALSE(is_still(resting(0.0, {{0.0, 0.0, 0.3}, Eigen::Vector3d::Zero()})));
}

TEST(AssessStillness, GravityInUnitsOfGIsNotStill) {
  auto samples = resting();
  for (ImuSample& sample : samples) sample.linear_acceleration /= 9.81;
  EXPECT_FALSE(is_still(samples));
}

TEST(AssessStillness, AFewBrokenReadingsDoNotMatterManyDo) {
  auto samples = resting();
  for (std::size_t i = 50; i < 55; ++i) samples[i].angular_velocity.setConstant(NAN);
  samples[70].linear_acceleration.setConstant(1e30);
  EXPECT_TRUE(is_still(samples));
  for (std::size_t i = 0; i < 120; ++i) samples[i].angular_velocity.setConstant(NAN);
  EXPECT_FALSE(is_still(samples));
  EXPECT_FALSE(is_still({}));
}

TEST(AlignToGravity, FindsRollPitchAndGyroBias) {
  const auto alignment = align_to_gravity(resting(0.2), stamp(0.0), ImuNoise{});
  ASSERT_TRUE(alignment.has_value());
  const Eigen::Vector3d up_body = kAttitude.inverse() * Eigen::Vector3d::UnitZ();
  const Eigen::Vector3d up = alignment->R_world_body * up_body;
  const double tilt = std::acos(std::min(1.0, up.z()));
  EXPECT_LT(tilt, 0.006);  // the accelerometer's bias: 0.05 / 9.81
  EXPECT_LT(tilt, 2.0 * alignment->tilt_std);
  const Eigen::Vector3d error = alignment->bias.gyro - kBias.gyro;
  EXPECT_LT(error.norm(), 1e-3);
  EXPECT_LT(error.dot(alignment->gyro_bias_covariance.inverse() * error), 16.0);
}

TEST(AlignToGravity, SaysNothingInMotion) {
  EXPECT_FALSE(align_to_gravity(SineMotion().samples(0.0, 2.0, 200.0), stamp(0.0), ImuNoise{}));
  EXPECT_FALSE(align_to_gravity({}, stamp(0.0), ImuNoise{}));
}

TEST(UprightRotation, TurnsTheForceUpFromAnywhere) {
  for (const Eigen::Vector3d& force :
       {Eigen::Vector3d(0, 0, 9.8), Eigen::Vector3d(0, 0, -9.8), Eigen::Vector3d(9.1, 0.1, -3.7)}) {
    expect_near(upright_rotation(force) * force, force.norm() * Eigen::Vector3d::UnitZ(), 1e-12);
  }
  EXPECT_THROW(upright_rotation(Eigen::Vector3d::Zero()), ContractError);
}

TEST(StaticDetectorOptions, RejectABinOfNoLength) {
  StaticDetectorOptions options;
  EXPECT_NO_THROW(options.validate());
  options.bin_s = 0.0;
  EXPECT_THROW(options.validate(), InputError);
}

}  // namespace
}  // namespace imslam::imu
