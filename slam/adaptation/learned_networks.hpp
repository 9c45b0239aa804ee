#pragma once

#include <filesystem>
#include <memory>
#include <string>
#include <vector>

#include "imu_net/imu_network.hpp"
#include "slam/adaptation/adaptation_options.hpp"
#include "slam/nn/model_card.hpp"
#include "slam/nn/weights_io.hpp"
#include "slam/sensors/device_calibration.hpp"
#include "slam/system/front_end.hpp"
#include "vo_net/match_network.hpp"
#include "vo_net/motion_noise.hpp"
#include "vo_net/pose_head.hpp"

namespace imslam::adaptation {

/// The networks of a run while they learn, as one list of parameters:
/// "match_network/encoder...", "motion_noise/...", "pose_head/...", "imu_network/...", and what
/// is known of the devices, "device/calibration" (of one) or "device/FINGERPRINT" (of several),
/// which no optimiser moves: the graph says it.
/// Networks that do not take part in the run, or are not to learn, are not in the list.
class LearnedNetworks {
 public:
  /// Those that the options of a run name, with their weights, on these devices (one or more, with
  /// their fingerprints). What the readings of one sensor alone have is learned where there is one
  /// device. Throws InputError(kModel), and kUsage if there is none to learn.
  LearnedNetworks(const system::SlamOptions& slam,
                  const AdaptationOptions& options,
                  std::vector<DeviceCalibration> devices);
  LearnedNetworks(const LearnedNetworks&) = delete;
  LearnedNetworks& operator=(const LearnedNetworks&) = delete;

  const nn::ParameterList<float>& parameters() const { return list_; }

  vo::MatchNetwork<float>* match() const { return match_.get(); }  ///< not folded, or null
  const vo::MotionNoise<float>* motion_noise() const { return noise_.get(); }
  vo::PoseHead<float>* pose_head() const { return head_.get(); }
  const imu::ImuNetwork<float>* imu_network() const { return imu_.get(); }

  /// Copies for a run, as they are now.
  system::Networks snapshot() const;

  /// As a run with snapshot() is to assume it, in the order of the constructor.
  DeviceCalibration device(std::size_t index = 0) const;
  void set_device(const DeviceCalibration& device, std::size_t index = 0);
  std::size_t device_count() const { return known_devices_.size(); }

  /// The weights of `joint` (all parameters, as save() of a training wrote them), one file per
  /// network in `folder`, in float16. Cards: `card` with what is known of each network before.
  /// What belongs to a device alone, the constant errors of its readings included, goes to
  /// device.yaml (one) or devices/FINGERPRINT.yaml (several): the networks stay good for others.
  std::vector<std::filesystem::path> write(const std::filesystem::path& joint,
                                           const std::filesystem::path& folder,
                                           const nn::ModelCard& card);

 private:
  struct Part {
    std::string name;
    nn::ParameterList<float> parameters;
    nn::ModelCard card;  ///< of the weights that it began with
  };
  template <typename Network>
  void adopt(const std::string& name, Network& network, const nn::ModelCard& card);
  void choose(const AdaptationOptions& options);
  DeviceCalibration device_of(const nn::WeightsFile& joint, std::size_t index) const;
  void write_devices(const nn::WeightsFile& joint, const std::filesystem::path& folder) const;

  std::shared_ptr<vo::MatchNetwork<float>> match_;
  std::shared_ptr<vo::MotionNoise<float>> noise_;
  std::shared_ptr<vo::PoseHead<float>> head_;
  std::shared_ptr<imu::ImuNetwork<float>> imu_;
  std::vector<DeviceCalibration> known_devices_;  ///< what the networks do not hold of them
  std::vector<nn::Parameter<float>> calibrations_;
  std::vector<Part> parts_;
  nn::ParameterList<float> list_;
};

/// The networks that are in a folder that write() filled, as assignments to the keys of a run:
/// "imu_network.weights=FOLDER/imu_network.safetensors". Throws InputError(kModel) if there is
/// none.
std::vector<std::string> network_assignments(const std::filesystem::path& folder);

/// The options of a run with these networks.
void use_networks(const std::filesystem::path& folder, system::SlamOptions& slam);

}  // namespace imslam::adaptation
