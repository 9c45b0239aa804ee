#include "slam/adaptation/rehearsal.hpp"

#include <gtest/gtest.h>

#include <algorithm>

#include "imu_net/imu_weights.hpp"
#include "slam/adaptation/learned_networks.hpp"

namespace imslam::adaptation {
namespace {

imu::ImuNetwork<float> shipped(const ImuBias& offset) {
  return *imu::load_imu_network("", offset).network;
}

double loss_of(const imu::ImuNetwork<float>& network, std::uint64_t index) {
  const training::InertialLogGenerator generator(rehearsal_logs(1));
  nn::Tape<float> tape;
  return static_cast<double>(tape.number(rehearsal(tape, network, generator, index)));
}

TEST(Rehearsal, IsDecidedByItsIndex) {
  const auto network = shipped({});
  EXPECT_EQ(loss_of(network, 3), loss_of(network, 3));
  EXPECT_NE(loss_of(network, 3), loss_of(network, 4));
}

TEST(Rehearsal, IsNotAboutTheSensorWhoseOffsetIsKnown) {
  ImuBias offset;
  offset.gyro = {0.05, -0.08, 0.02};
  EXPECT_EQ(loss_of(shipped(offset), 3), loss_of(shipped({}), 3));
}

TEST(Rehearsal, ANetworkThatForgotIsTold) {
  imu::ImuNetwork<float> network = shipped({});
  const double before = loss_of(network, 3);
  network.last.bias.value.array() += 2.0F;
  EXPECT_GT(loss_of(network, 3), before + 0.1);
}

/// Parameters of the IMU network that an optimiser may move.
std::vector<std::string> learning(const std::string& layers) {
  AdaptationOptions options;
  options.imu_layers = layers;
  options.motion_noise = false;
  system::SlamOptions slam;
  slam.system.imu = "learned";
  const LearnedNetworks networks(slam, options, {DeviceCalibration()});
  std::vector<std::string> names;
  for (const nn::Parameter<float>* parameter : networks.parameters()) {
    if (parameter->trainable) names.push_back(parameter->name);
  }
  return names;
}

TEST(LearnedNetworks, LetsTheChosenLayersLearn) {
  EXPECT_EQ(learning("offset"), std::vector<std::string>{"imu_network/sensor_offset"});
  const auto last = learning("last");
  EXPECT_EQ(last.size(), 3U);
  EXPECT_EQ(std::count(last.begin(), last.end(), "imu_network/last.weight"), 1);
  EXPECT_GT(learning("all").size(), 8U);
}

TEST(LearnedNetworks, TheOffsetOfOneSensorIsNotLearnedFromSeveral) {
  AdaptationOptions options;
  system::SlamOptions slam;
  slam.system.imu = "learned";
  DeviceCalibration one;
  one.device = "one";
  DeviceCalibration two;
  two.device = "two";
  two.disparity_offset_px = 0.25;
  const LearnedNetworks networks(slam, options, {one, two});
  EXPECT_EQ(networks.device(1).disparity_offset_px, 0.25);
  EXPECT_EQ(networks.device(0).disparity_offset_px, 0.0);
  for (const nn::Parameter<float>* parameter : networks.parameters()) {
    EXPECT_FALSE(parameter->trainable && parameter->name == "imu_network/sensor_offset");
  }
}

}  // namespace
}  // namespace imslam::adaptation
