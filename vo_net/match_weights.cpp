#include "vo_net/match_weights.hpp"

#include <utility>

#include "slam/base/random.hpp"
#include "slam/nn/shipped_file.hpp"

namespace imslam::vo {
namespace {

constexpr const char* kWithout =
    "the learned front end has no weights: this program was built without "
    "vo_net/weights/match_network.safetensors; train them with `imslam train vo` and give the "
    "file with --set vo.learned.weights=FILE, or use --front-end klt";

}  // namespace

TrainedMatchNetwork load_match_network(const std::string& file, MatchUse use) {
  const nn::WeightsFile weights =
      nn::read_or_shipped(file, shipped_match_weights(), "match_network.safetensors", kWithout);
  Random random(0);  // every number that it draws is replaced
  auto network = std::make_shared<MatchNetwork<float>>(MatchNetworkOptions(), random);
  nn::ModelCard card = nn::load_network(weights, *network);
  if (use == MatchUse::kInference) network->fold();
  network->freeze_norms(true);
  return {std::move(network), weights.name(), std::move(card)};
}

}  // namespace imslam::vo
