#include "slam/plugins/routing/routing_weights.hpp"

#include <fmt/format.h>

#include "slam/nn/shipped_file.hpp"

namespace imslam::routing {

std::shared_ptr<const AllocationNetwork<float>> load_network(int agents, const std::string& file) {
  const std::string without = fmt::format(
      "this program was built without a network for {0} agents; train one with `imslam route train "
      "--agents {0}` and give it with --weights, or use --method search",
      agents);
  const nn::WeightsFile weights = nn::read_or_shipped(
      file, shipped_weights(agents), fmt::format("allocation_network_{}.safetensors", agents),
      without.c_str());
  Random random(0);  // every number that it draws is replaced
  auto network = std::make_shared<AllocationNetwork<float>>(agents, AllocationSizes(), random);
  nn::ParameterList<float> parameters;
  network->collect(parameters);
  nn::load_parameters(weights, parameters);
  return network;
}

}  // namespace imslam::routing
