#include "imu_net/bias_observers.hpp"

#include <gtest/gtest.h>

#include "slam/base/random.hpp"
#include "tests/support/numeric_jacobian.hpp"

namespace imslam::imu {
namespace {

using imslam::testing::expect_near;

const Eigen::Vector3d kGyroBias(0.02, -0.05, 0.08);

ImuBin bin_of(const Eigen::Vector3d& rate, const Eigen::Vector3d& force) {
  ImuBin bin;
  bin.count = 20;
  bin.rate = rate;
  bin.force = force;
  return bin;
}

TEST(RestObserver, TakesTheMeanRateAtRestForTheBias) {
  RestObserver observer{ImuNoise{}};
  Random random(1);
  for (int i = 0; i < 30; ++i) {
    observer.add(bin_of(kGyroBias + 5e-4 * random.normal3(), {0.0, 0.0, 9.81}), 0.1);
  }
  EXPECT_TRUE(observer.still());
  const BiasBelief belief = observer.gyro();
  expect_near(belief.bias, kGyroBias, 1e-3);
  EXPECT_LT(belief.sigma.maxCoeff(), 5e-4);
}

TEST(RestObserver, DoesNotLearnFromTheMomentsBeforeAStart) {
  RestObserver observer{ImuNoise{}};
  for (int i = 0; i < 20; ++i) observer.add(bin_of(kGyroBias, {0.0, 0.0, 9.81}), 0.1);
  for (int i = 0; i < 20; ++i) {  // speeds up gently, then too much to be rest
    const Eigen::Vector3d turn(0.0, 0.0, 0.004 * i * i);
    observer.add(bin_of(kGyroBias + turn, {0.0, 0.0, 9.81}), 0.1);
  }
  EXPECT_FALSE(observer.still());
  expect_near(observer.gyro().bias, kGyroBias, 2e-3);
}

TEST(RestObserver, KnowsNothingWithoutRestAndForgetsSlowly) {
  RestObserver observer{ImuNoise{}};
  for (int i = 0; i < 50; ++i) {
    observer.add(bin_of({std::sin(0.3 * i), 0.0, 0.0}, {0.0, 0.0, 9.81}), 0.1);
  }
  EXPECT_EQ(observer.gyro().bias, Eigen::Vector3d::Zero());
  EXPECT_GT(observer.gyro().sigma.minCoeff(), 0.19);
  EXPECT_NEAR(observer.time_since_rest_s(), 5.0, 1e-9);
}

TEST(RestObserver, FindsTheAccelerometersBiasAlongGravityOnly) {
  RestObserver observer{ImuNoise{}};
  for (int i = 0; i < 50; ++i)
    observer.add(bin_of(Eigen::Vector3d::Zero(), {0.3, 0.0, 9.81 + 0.2}), 0.1);
  const BiasBelief belief = observer.accel();
  EXPECT_NEAR(belief.bias.z(), 0.2, 0.03);
  EXPECT_LT(belief.sigma.z(), 0.05);
  EXPECT_GT(belief.sigma.y(), 0.25);
}

/// A body that tips to and fro about all axes without acceleration.
TEST(GravityObserver, FindsTheBiasFromWhereUpIs) {
  GravityObserver observer{ImuNoise{}, {}};
  lie::SO3d R_world_body;
  for (int i = 0; i < 900; ++i) {
    const double t = 0.1 * i;
    const Eigen::Vector3d rate(0.5 * std::sin(0.5 * t), 0.4 * std::sin(0.7 * t), 0.3);
    R_world_body = R_world_body * lie::SO3d::exp(0.1 * rate);
    const Eigen::Vector3d force = R_world_body.inverse() * Eigen::Vector3d(0.0, 0.0, 9.81);
    observer.add(bin_of(rate + kGyroBias, force), 0.1, std::nullopt);
  }
  const BiasBelief belief = observer.gyro();
  const Eigen::Vector3d off = belief.bias - kGyroBias;
  EXPECT_LT(off.norm(), 5e-3);
  for (int i = 0; i < 3; ++i) EXPECT_LT(std::abs(off[i]), 4.0 * belief.sigma[i]);
}

TEST(GravityObserver, StartsFromWhatRestHasShown) {
  GravityObserver observer{ImuNoise{}, {}};
  const RestReading rest{kGyroBias, Eigen::Vector3d::Constant(1e-6)};
  for (int i = 0; i < 20; ++i) observer.add(bin_of(kGyroBias, {0.0, 0.0, 9.81}), 0.1, rest);
  expect_near(observer.gyro().bias, kGyroBias, 1e-3);
  EXPECT_LT(observer.gyro().sigma.maxCoeff(), 1e-3);
}

TEST(GravityObserver, SaysThatItCannotSeeATurnAboutTheVertical) {
  GravityObserver observer{ImuNoise{}, {}};
  for (int i = 0; i < 900; ++i) {
    observer.add(bin_of(kGyroBias, {0.0, 0.0, 9.81}), 0.1, std::nullopt);
  }
  const BiasBelief belief = observer.gyro();
  expect_near(belief.bias.head<2>(), kGyroBias.head<2>(), 3e-3);
  EXPECT_LT(belief.sigma.head<2>().maxCoeff(), 0.02);
  EXPECT_GT(belief.sigma.z(), 0.18);
}

TEST(MeanObserver, TheMeanOfTurningToAndFroIsTheBias) {
  MeanObserver observer;
  for (int i = 0; i < 1200; ++i) {
    const Eigen::Vector3d turn = Eigen::Vector3d::Constant(0.4 * std::sin(0.2 * i));
    observer.add(bin_of(kGyroBias + turn, {0.0, 0.0, 9.81}));
  }
  expect_near(observer.gyro().bias, kGyroBias, 5e-3);
  expect_near(observer.rate_rms(), Eigen::Vector3d::Constant(0.4 / std::sqrt(2.0)), 0.02);
}

}  // namespace
}  // namespace imslam::imu
