#pragma once

#include <optional>
#include <string>
#include <utility>

#include "slam/base/error.hpp"
#include "slam/nn/weights_io.hpp"

namespace imslam::nn {

/// The weights that a user names; `file` empty: those that the program was shipped with.
/// Throws InputError(kModel): `without` if there are none, else as WeightsFile does.
inline WeightsFile read_or_shipped(const std::string& file,
                                   std::optional<std::string> shipped,
                                   const std::string& shipped_name,
                                   const char* without) {
  if (!file.empty()) return WeightsFile::read(file);
  if (shipped) return WeightsFile::parse(shipped_name + " (shipped)", std::move(*shipped));
  throw InputError(without, ExitCode::kModel);
}

/// Fills all parameters of a network. Returns the file's card, with the sha256 of the tensors even
/// where the file states none. Throws as load_parameters() does.
template <typename Network>
ModelCard load_network(const WeightsFile& weights, Network& network) {
  ParameterList<float> parameters;
  network.collect(parameters);
  load_parameters(weights, parameters);
  ModelCard card = weights.card();
  card.sha256 = weights.data_sha256();
  return card;
}

}  // namespace imslam::nn
