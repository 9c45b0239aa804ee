#include "vo_net/match_weights.hpp"

#include <utility>

#include "slam/base/error.hpp"
#include "slam/base/random.hpp"
#include "slam/nn/weights_io.hpp"

namespace imslam::vo {
namespace {

constexpr const char* kShippedName = "match_network.safetensors (shipped)";

nn::WeightsFile read_weights(const std::string& file) {
  if (!file.empty()) return nn::WeightsFile::read(file);
  std::optional<std::string> shipped = shipped_match_weights();
  if (shipped) return nn::WeightsFile::parse(kShippedName, std::move(*shipped));
  throw InputError(
      "the learned front end has no weights: this program was built without "
      "vo_net/weights/match_network.safetensors; train them with `imslam train vo` and give the "
      "file with --set vo.learned.weights=FILE, or use --front-end klt",
      ExitCode::kModel);
}

}  // namespace

TrainedMatchNetwork load_match_network(const std::string& file) {
  const nn::WeightsFile weights = read_weights(file);
  Random random(0);  // every number that it draws is replaced
  auto network = std::make_shared<MatchNetwork<float>>(MatchNetworkOptions(), random);
  nn::ParameterList<float> parameters;
  network->collect(parameters);
  nn::load_parameters(weights, parameters);
  network->fold();
  nn::ModelCard card = weights.card();
  card.sha256 = weights.data_sha256();
  return {std::move(network), weights.name(), std::move(card)};
}

}  // namespace imslam::vo
