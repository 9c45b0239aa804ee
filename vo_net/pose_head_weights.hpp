#pragma once

#include <memory>
#include <optional>
#include <string>

#include "slam/nn/model_card.hpp"
#include "vo_net/pose_head.hpp"

namespace imslam::vo {

/// A pose head ready for use and what is known about its weights.
struct TrainedPoseHead {
  std::shared_ptr<const PoseHead<float>> network;
  std::string file;    ///< where the weights are from
  nn::ModelCard card;  ///< with the sha256 of the tensors, always
};

/// Reads the weights of a pose head of default sizes; `file` empty: those that the program was
/// shipped with. Throws InputError(kModel) if there are none, if they are damaged, or those of
/// another network.
TrainedPoseHead load_pose_head(const std::string& file);

/// The bytes of weights/pose_head.safetensors, built into the program; none if the file was not
/// there.
std::optional<std::string> shipped_pose_head();

}  // namespace imslam::vo
