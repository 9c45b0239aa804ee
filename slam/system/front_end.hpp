#pragma once

#include <memory>
#include <string>
#include <vector>

#include "imu_net/imu_network.hpp"
#include "slam/nn/model_card.hpp"
#include "slam/sensors/calibration.hpp"
#include "slam/sensors/device_calibration.hpp"
#include "slam/system/slam_options.hpp"
#include "vo_net/match_network.hpp"
#include "vo_net/match_recording.hpp"
#include "vo_net/matcher.hpp"
#include "vo_net/motion_noise.hpp"
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
  std::shared_ptr<const vo::PoseHead<float>> pose_head;        ///< none: the geometric head
  std::shared_ptr<const vo::MotionNoise<float>> motion_noise;  ///< none: covariances as they are
  std::shared_ptr<const imu::ImuNetwork<float>> imu_network;   ///< none: raw readings
  std::vector<ModelRecord> models;
};

/// Networks that are used instead of those that the options name, e.g. while they learn.
struct Networks {
  std::shared_ptr<const vo::MatchRecording> matches;   ///< instead of any matcher; or null
  std::shared_ptr<vo::MatchRecording> record_matches;  ///< where the matcher's go; or null
  std::shared_ptr<vo::MatchNetwork<float>> match;      ///< folded: for inference only
  std::shared_ptr<const vo::PoseHead<float>> pose_head;
  std::shared_ptr<const vo::MotionNoise<float>> motion_noise;
  std::shared_ptr<const imu::ImuNetwork<float>> imu_network;
};

/// The matcher that options.system.front_end names, the head that options.vo.head names, the IMU
/// network if options.system.imu asks for it; those of `networks` (may be null) come first. An IMU
/// network that is not among them learns from `device` what its sensor alone has. Throws
/// InputError(kModel) if they need weights and there are none.
FrontEnd make_front_end(const SlamOptions& options,
                        const StereoCamera& camera,
                        const Networks* networks = nullptr,
                        const DeviceCalibration& device = {});

}  // namespace imslam::system
