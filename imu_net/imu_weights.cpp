#include "imu_net/imu_weights.hpp"

#include <utility>

#include "slam/base/config.hpp"
#include "slam/base/random.hpp"
#include "slam/nn/shipped_file.hpp"

namespace imslam::imu {
namespace {

constexpr const char* kWithout =
    "the learned IMU correction has no weights: this program was built without "
    "imu_net/weights/imu_network.safetensors; train them with `imslam train imu` and give the "
    "file with --set imu_network.weights=FILE, or use --imu raw";

}  // namespace

void ImuNetworkOptions::describe(Config& config) {
  config.field("weights", weights, "weight file; empty: the shipped ones");
  config.field("beliefs", beliefs, "what the network believes of the biases enters the graph");
  config.field("noise_factor", noise_factor,
               "on the datasheet's noise density; the network's own is added");
}

TrainedImuNetwork load_imu_network(const std::string& file, const ImuBias& reading_offset) {
  const nn::WeightsFile weights =
      nn::read_or_shipped(file, shipped_imu_weights(), "imu_network.safetensors", kWithout);
  Random random(0);  // every number that it draws is replaced
  auto network = std::make_shared<ImuNetwork<float>>(ImuNetworkSizes(), random);
  nn::ModelCard card = nn::load_network(weights, *network);
  ImuBias offset = network->reading_offset();
  offset.gyro += reading_offset.gyro;
  offset.accel += reading_offset.accel;
  network->set_reading_offset(offset);
  return {std::move(network), weights.name(), std::move(card)};
}

}  // namespace imslam::imu
