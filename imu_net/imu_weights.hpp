#pragma once

#include <memory>
#include <optional>
#include <string>

#include "imu_net/imu_network.hpp"
#include "slam/nn/model_card.hpp"

namespace imslam {
class Config;
}

namespace imslam::imu {

struct ImuNetworkOptions {
  std::string weights;        ///< file; empty: the shipped ones
  bool beliefs = true;        ///< what the network believes of the biases enters the graph
  double noise_factor = 2.0;  ///< on the datasheet's density; the network's own is added

  void describe(Config& config);
};

/// A network ready for use and what is known about its weights.
struct TrainedImuNetwork {
  std::shared_ptr<const ImuNetwork<float>> network;
  std::string file;    ///< where the weights are from
  nn::ModelCard card;  ///< with the sha256 of the tensors, always
};

/// Reads the weights of a network of default sizes; `file` empty: those that the program was
/// shipped with. Throws InputError(kModel) if there are none, if they are damaged, or those of
/// another network. `reading_offset`: what the sensor at hand is known to have, on top of the
/// file's own.
TrainedImuNetwork load_imu_network(const std::string& file, const ImuBias& reading_offset = {});

/// The bytes of weights/imu_network.safetensors, built into the program; none if the file was not
/// there.
std::optional<std::string> shipped_imu_weights();

}  // namespace imslam::imu
