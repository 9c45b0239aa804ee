#include "vo_net/pose_head_weights.hpp"

#include <utility>

#include "slam/base/random.hpp"
#include "slam/nn/shipped_file.hpp"

namespace imslam::vo {
namespace {

constexpr const char* kWithout =
    "vo.head: regression has no weights: this program was built without "
    "vo_net/weights/pose_head.safetensors; train them with `imslam train pose_head` and give the "
    "file with --set vo.regression.weights=FILE, or use --set vo.head=geometric";

}  // namespace

TrainedPoseHead load_pose_head(const std::string& file) {
  const nn::WeightsFile weights =
      nn::read_or_shipped(file, shipped_pose_head(), "pose_head.safetensors", kWithout);
  Random random(0);  // every number that it draws is replaced
  auto network = std::make_shared<PoseHead<float>>(PoseHeadSizes(), random);
  nn::ModelCard card = nn::load_network(weights, *network);
  return {std::move(network), weights.name(), std::move(card)};
}

}  // namespace imslam::vo
