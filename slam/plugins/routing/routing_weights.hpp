#pragma once

#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "slam/plugins/routing/allocation_network.hpp"

namespace imslam::routing {

/// For how many agents the program was shipped with a network.
std::vector<int> shipped_agents();

/// The bytes of weights/allocation_network_<agents>.safetensors, built into the program; none if
/// the file was not there.
std::optional<std::string> shipped_weights(int agents);

/// Reads the weights of a network of default sizes; `file` empty: those that the program was
/// shipped with. Throws InputError(kModel) if there are none, if they are damaged, or those of
/// another network.
std::shared_ptr<const AllocationNetwork<float>> load_network(int agents, const std::string& file);

}  // namespace imslam::routing
