#pragma once

#include <memory>
#include <optional>
#include <string>

#include "slam/nn/model_card.hpp"
#include "vo_net/match_network.hpp"

namespace imslam::vo {

/// A network ready for use and what is known about its weights.
struct TrainedMatchNetwork {
  std::shared_ptr<MatchNetwork<float>> network;  ///< folded unless wanted otherwise
  std::string file;                              ///< where the weights are from
  nn::ModelCard card;                            ///< with the sha256 of the tensors, always
};

enum class MatchUse {
  kInference,  ///< folded, see MatchNetwork::fold()
  kTraining,   ///< as it was trained, norms frozen
};

/// Reads the weights of a network with default MatchNetworkOptions; `file` empty: those that the
/// program was shipped with. Throws InputError(kModel) if there are none, if they are damaged, or
/// those of another network.
TrainedMatchNetwork load_match_network(const std::string& file,
                                       MatchUse use = MatchUse::kInference);

/// The bytes of weights/match_network.safetensors, built into the program; none if the file was
/// not there.
std::optional<std::string> shipped_match_weights();

}  // namespace imslam::vo
