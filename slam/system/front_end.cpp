#include "slam/system/front_end.hpp"

#include <utility>

#include "imu_net/imu_weights.hpp"
#include "vo_net/klt_matcher.hpp"
#include "vo_net/learned_matcher.hpp"
#include "vo_net/match_weights.hpp"
#include "vo_net/pose_head_weights.hpp"

namespace imslam::system {

namespace {

/// The network at hand, or the trained one that `load` reads; that one is put on record.
template <typename Network, typename Load>
std::shared_ptr<Network> network_of(const std::shared_ptr<Network>& at_hand,
                                    const char* name,
                                    const Load& load,
                                    FrontEnd& front_end) {
  if (at_hand) return at_hand;
  auto trained = load();
  front_end.models.push_back({name, std::move(trained.file), std::move(trained.card)});
  return std::move(trained.network);
}

}  // namespace

FrontEnd make_front_end(const SlamOptions& options,
                        const StereoCamera& camera,
                        const Networks* networks,
                        const DeviceCalibration& device) {
  const Networks given = networks != nullptr ? *networks : Networks();
  FrontEnd front_end;
  if (given.matches) {
    front_end.matcher = std::make_unique<vo::ReplayingMatcher>(given.matches);
  } else if (options.system.front_end == "klt") {
    front_end.matcher = std::make_unique<vo::KltMatcher>(options.vo.klt, camera);
  } else {
    const auto load = [&] { return vo::load_match_network(options.vo.learned.weights); };
    front_end.matcher = std::make_unique<vo::LearnedMatcher>(
        options.vo.learned, camera, network_of(given.match, "match_network", load, front_end));
  }
  if (given.record_matches) {
    front_end.matcher =
        std::make_unique<vo::RecordingMatcher>(std::move(front_end.matcher), given.record_matches);
  }
  if (options.vo.head == "regression") {
    const auto load = [&] { return vo::load_pose_head(options.vo.regression.weights); };
    front_end.pose_head = network_of(given.pose_head, "pose_head", load, front_end);
  }
  if (given.motion_noise || !options.vo.motion_noise.empty()) {
    const auto load = [&] { return vo::load_motion_noise(options.vo.motion_noise); };
    front_end.motion_noise = network_of(given.motion_noise, "motion_noise", load, front_end);
  }
  if (options.system.imu == "learned") {
    const auto load = [&] {
      return imu::load_imu_network(options.imu_network.weights, device.reading_offset);
    };
    front_end.imu_network = network_of(given.imu_network, "imu_network", load, front_end);
  }
  return front_end;
}

}  // namespace imslam::system
