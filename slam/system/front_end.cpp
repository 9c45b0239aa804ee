#include "slam/system/front_end.hpp"

#include <utility>

#include "imu_net/imu_weights.hpp"
#include "vo_net/klt_matcher.hpp"
#include "vo_net/learned_matcher.hpp"
#include "vo_net/match_weights.hpp"
#include "vo_net/pose_head_weights.hpp"

namespace imslam::system {

namespace {

void add_matcher(const SlamOptions& options, const StereoCamera& camera, FrontEnd& front_end) {
  if (options.system.front_end == "klt") {
    front_end.matcher = std::make_unique<vo::KltMatcher>(options.vo.klt, camera);
    return;
  }
  vo::TrainedMatchNetwork trained = vo::load_match_network(options.vo.learned.weights);
  front_end.matcher =
      std::make_unique<vo::LearnedMatcher>(options.vo.learned, camera, std::move(trained.network));
  front_end.models.push_back({"match_network", std::move(trained.file), std::move(trained.card)});
}

void add_head(const SlamOptions& options, FrontEnd& front_end) {
  if (options.vo.head != "regression") return;
  vo::TrainedPoseHead trained = vo::load_pose_head(options.vo.regression.weights);
  front_end.pose_head = std::move(trained.network);
  front_end.models.push_back({"pose_head", std::move(trained.file), std::move(trained.card)});
}

void add_imu_network(const SlamOptions& options, FrontEnd& front_end) {
  if (options.system.imu != "learned") return;
  imu::TrainedImuNetwork trained = imu::load_imu_network(options.imu_network.weights);
  front_end.imu_network = std::move(trained.network);
  front_end.models.push_back({"imu_network", std::move(trained.file), std::move(trained.card)});
}

}  // namespace

FrontEnd make_front_end(const SlamOptions& options, const StereoCamera& camera) {
  FrontEnd front_end;
  add_matcher(options, camera, front_end);
  add_head(options, front_end);
  add_imu_network(options, front_end);
  return front_end;
}

}  // namespace imslam::system
