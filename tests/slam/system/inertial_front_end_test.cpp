#include "slam/system/inertial_front_end.hpp"

#include <gtest/gtest.h>

#include "slam/base/random.hpp"
#include "slam/base/time.hpp"

namespace imslam::system {
namespace {

/// A network whose every answer is some number.
std::shared_ptr<const imu::ImuNetwork<float>> some_network() {
  Random random(5);
  auto network = std::make_shared<imu::ImuNetwork<float>>(imu::ImuNetworkSizes(), random);
  nn::initialise_uniform(network->last.weight, 0.5, random);
  return network;
}

std::vector<ImuSample> readings(double duration_s) {
  std::vector<ImuSample> samples;
  Random random(1);
  for (int i = 0; i < static_cast<int>(duration_s * 200.0); ++i) {
    ImuSample sample;
    sample.time_ns = to_nanoseconds(0.005 * i);
    sample.angular_velocity = Eigen::Vector3d(0.02, -0.03, 0.08) + 2e-3 * random.normal3();
    sample.linear_acceleration = Eigen::Vector3d(0.0, 0.0, 9.81) + 0.02 * random.normal3();
    samples.push_back(sample);
  }
  return samples;
}

TEST(InertialFrontEnd, ReadingsKeepTheirValuesAndGainNoise) {
  InertialFrontEnd front_end(some_network(), ImuNoise());
  ImuSample last;
  for (const ImuSample& sample : readings(3.0)) {
    last = front_end.add(sample);
    ASSERT_EQ(last.angular_velocity, sample.angular_velocity);
    ASSERT_EQ(last.linear_acceleration, sample.linear_acceleration);
  }
  EXPECT_GT(last.gyro_variance.minCoeff(), 0.0);
  EXPECT_GT(last.accel_variance.minCoeff(), 0.0);
}

TEST(InertialFrontEnd, BelievesEachAxisWhereItWasSurest) {
  const auto network = some_network();
  InertialFrontEnd front_end(network, ImuNoise());
  imu::ImuCorrector corrector(network, ImuNoise());
  EXPECT_TRUE(front_end.beliefs().empty());
  double surest = 1e300;
  double bias_then = 0.0;
  for (const ImuSample& sample : readings(5.0)) {
    front_end.add(sample);
    corrector.correct(sample);
    const imu::ImuCorrection* const said = corrector.correction();
    if (said == nullptr || said->sigma.gyro.y() >= surest) continue;
    surest = said->sigma.gyro.y();
    bias_then = said->offset.gyro.y();
  }
  ASSERT_EQ(front_end.beliefs().size(), 6U);
  for (int axis = 0; axis < 6; ++axis) {
    EXPECT_EQ(front_end.beliefs()[static_cast<std::size_t>(axis)].axis, axis);
  }
  EXPECT_EQ(front_end.beliefs()[1].sigma, surest);
  EXPECT_EQ(front_end.beliefs()[1].bias, bias_then);
  EXPECT_EQ(front_end.bias().gyro, corrector.correction()->offset.gyro);
}

}  // namespace
}  // namespace imslam::system
