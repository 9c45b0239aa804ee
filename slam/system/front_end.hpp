#pragma once

#include <memory>
#include <string>
#include <vector>

#include "imu_net/imu_network.hpp"
#include "slam/nn/model_card.hpp"
#include "slam/sensors/calibration.hpp"
#include "slam/system/slam_options.hpp"
#include "vo_net/matcher.hpp"
#include "vo_net/pose_head.hpp"

namespace imslam::system {

/// A trained network that took part in a run.
struct ModelRecord {
  std::string name;  ///< its task: match_network, pose_head, imu_network
  std::string file;
  nn::ModelCard card;  ///< with the sha256 of the tensors
};

struct FrontEnd {
  std::unique_ptr<vo::Matcher> matcher;
  std::shared_ptr<const vo::PoseHead<float>> pose_head;       ///< none: the geometric head
  std::shared_ptr<const imu::ImuNetwork<float>> imu_network;  ///< none: raw readings
  std::vector<ModelRecord> models;
};

/// The matcher that options.system.front_end names, the head that options.vo.head names, the IMU
/// network if options.system.imu asks for it. Throws InputError(kModel) if they need weights and
/// there are none.
FrontEnd make_front_end(const SlamOptions& options, const StereoCamera& camera);

}  // namespace imslam::system
