#include "slam/adaptation/learned_networks.hpp"

#include <type_traits>
#include <utility>

#include "imu_net/imu_weights.hpp"
#include "slam/base/config.hpp"
#include "slam/base/error.hpp"
#include "slam/nn/weights_io.hpp"
#include "vo_net/match_weights.hpp"
#include "vo_net/pose_head_weights.hpp"

namespace imslam::adaptation {
namespace {

constexpr const char* kMatch = "match_network";
constexpr const char* kNoise = "motion_noise";
constexpr const char* kHead = "pose_head";
constexpr const char* kImu = "imu_network";
constexpr const char* kDeviceFile = "device.yaml";
constexpr const char* kDeviceFolder = "devices";

/// Focal error, disparity offset [px], time offset [s], camera rotation [rad].
constexpr nn::Index kCalibrationSize = 6;

void to_numbers(const DeviceCalibration& device, nn::Tensor<float>& numbers) {
  numbers[0] = static_cast<float>(device.focal_error);
  numbers[1] = static_cast<float>(device.disparity_offset_px);
  numbers[2] = static_cast<float>(device.time_offset_s);
  for (int axis = 0; axis < 3; ++axis) {
    numbers[3 + axis] = static_cast<float>(device.camera_rotation[axis]);
  }
}

void from_numbers(const nn::Tensor<float>& numbers, DeviceCalibration& device) {
  device.focal_error = static_cast<double>(numbers[0]);
  device.disparity_offset_px = static_cast<double>(numbers[1]);
  device.time_offset_s = static_cast<double>(numbers[2]);
  for (int axis = 0; axis < 3; ++axis) {
    device.camera_rotation[axis] = static_cast<double>(numbers[3 + axis]);
  }
}

template <typename Network>
void read_network(const std::string& name, Network& network, const nn::WeightsFile& joint) {
  nn::ParameterList<float> own;
  network.collect(own, "");
  for (nn::Parameter<float>* parameter : own) {
    joint.read_into(name + "/" + parameter->name, parameter->value);
  }
}

/// The weights of one network from the joint file, under their own names; of no device in
/// particular.
template <typename Network>
void write_network(const std::string& name,
                   Network network,
                   const nn::WeightsFile& joint,
                   const std::filesystem::path& file,
                   const nn::ModelCard& card) {
  read_network(name, network, joint);
  if constexpr (std::is_same_v<Network, imu::ImuNetwork<float>>) network.set_reading_offset({});
  nn::ParameterList<float> own;
  network.collect(own, "");
  nn::save_parameters(file, own, card, nn::NumberType::kF16);
}

/// Whether this part of the IMU network is to learn.
bool learns(const std::string& parameter, const AdaptationOptions& options) {
  const auto has = [&](const char* part) { return parameter.find(part) != std::string::npos; };
  if (options.imu_layers == "all" || has("sensor_offset")) return true;
  return options.imu_layers == "last" && has("/last");
}

/// A file with a number of its own for what is not to be seen twice.
nn::ModelCard untrained_noise_card() {
  nn::ModelCard card;
  card.what =
      "covariance of the motions of imslam's visual odometry: factors of translation and rotation "
      "from inliers, noise, disparity and flow of a motion";
  return card;
}

}  // namespace

LearnedNetworks::LearnedNetworks(const system::SlamOptions& slam,
                                 const AdaptationOptions& options,
                                 std::vector<DeviceCalibration> devices)
    : known_devices_(std::move(devices)) {
  expects(!known_devices_.empty(), "LearnedNetworks: at least one device");
  if (slam.system.front_end == "learned" && options.matcher != "off") {
    auto trained = vo::load_match_network(slam.vo.learned.weights, vo::MatchUse::kTraining);
    match_ = std::move(trained.network);
    adopt(kMatch, *match_, trained.card);
  }
  if (options.motion_noise) {
    nn::ModelCard card = untrained_noise_card();
    if (slam.vo.motion_noise.empty()) {
      Random random(static_cast<std::uint64_t>(options.seed));
      noise_ = std::make_shared<vo::MotionNoise<float>>(random);
    } else {
      auto trained = vo::load_motion_noise(slam.vo.motion_noise);
      noise_ = std::move(trained.network);
      card = std::move(trained.card);
    }
    adopt(kNoise, *noise_, card);
  }
  if (slam.vo.head == "regression" && options.pose_head) {
    const auto trained = vo::load_pose_head(slam.vo.regression.weights);
    head_ = std::make_shared<vo::PoseHead<float>>(*trained.network);
    adopt(kHead, *head_, trained.card);
  }
  if (slam.system.imu == "learned" && options.imu) {
    const bool one_sensor = device_count() == 1;  // what it alone has may be learned
    const auto trained = imu::load_imu_network(
        slam.imu_network.weights, one_sensor ? known_devices_[0].reading_offset : ImuBias());
    imu_ = std::make_shared<imu::ImuNetwork<float>>(*trained.network);
    imu_->sensor_offset.trainable = one_sensor;
    adopt(kImu, *imu_, trained.card);
  }
  if (parts_.empty()) {
    throw InputError(
        "nothing to learn: every network is off or not used by this run; try --front-end learned, "
        "or finetune.motion_noise=true",
        ExitCode::kUsage);
  }
  choose(options);
  calibrations_.resize(device_count());
  for (std::size_t i = 0; i < device_count(); ++i) {
    calibrations_[i] = nn::Parameter<float>(nn::Shape{kCalibrationSize}, false);
    set_device(known_devices_[i], i);
    list_.add(device_count() == 1 ? "device/calibration" : "device/" + known_devices_[i].device,
              calibrations_[i]);
  }
}

template <typename Network>
void LearnedNetworks::adopt(const std::string& name, Network& network, const nn::ModelCard& card) {
  Part part;
  part.name = name;
  part.card = card;
  network.collect(part.parameters, name + "/");
  for (nn::Parameter<float>* parameter : part.parameters) list_.add(parameter->name, *parameter);
  parts_.push_back(std::move(part));
}

void LearnedNetworks::choose(const AdaptationOptions& options) {
  for (Part& part : parts_) {
    for (nn::Parameter<float>* parameter : part.parameters) {
      const bool head = parameter->name.find(".head.") != std::string::npos;
      if (part.name == kMatch && options.matcher == "heads" && !head) parameter->trainable = false;
      if (part.name == kImu) parameter->rate_factor = options.imu_rate;
      if (part.name == kImu && !learns(parameter->name, options)) parameter->trainable = false;
      if (part.name == kNoise) parameter->rate_factor = options.noise_rate;
    }
  }
}

system::Networks LearnedNetworks::snapshot() const {
  system::Networks networks;
  if (match_) {
    networks.match = std::make_shared<vo::MatchNetwork<float>>(*match_);
    networks.match->fold();
  }
  if (noise_) networks.motion_noise = std::make_shared<vo::MotionNoise<float>>(*noise_);
  if (head_) networks.pose_head = std::make_shared<vo::PoseHead<float>>(*head_);
  if (imu_) networks.imu_network = std::make_shared<imu::ImuNetwork<float>>(*imu_);
  return networks;
}

DeviceCalibration LearnedNetworks::device(std::size_t index) const {
  DeviceCalibration device = known_devices_.at(index);
  from_numbers(calibrations_[index].value, device);
  return device;
}

void LearnedNetworks::set_device(const DeviceCalibration& device, std::size_t index) {
  to_numbers(device, calibrations_.at(index).value);
}

/// The numbers of the joint file.
DeviceCalibration LearnedNetworks::device_of(const nn::WeightsFile& joint,
                                             std::size_t index) const {
  nn::Tensor<float> numbers({kCalibrationSize});
  joint.read_into(calibrations_[index].name, numbers);
  DeviceCalibration device = known_devices_[index];
  from_numbers(numbers, device);
  if (imu_ && device_count() == 1) {
    imu::ImuNetwork<float> network = *imu_;
    read_network(kImu, network, joint);
    device.reading_offset = network.reading_offset();
  }
  return device;
}

void LearnedNetworks::write_devices(const nn::WeightsFile& joint,
                                    const std::filesystem::path& folder) const {
  if (device_count() == 1) return write_device(folder / kDeviceFile, device_of(joint, 0));
  std::filesystem::create_directories(folder / kDeviceFolder);
  for (std::size_t i = 0; i < device_count(); ++i) {
    write_device(folder / kDeviceFolder / (known_devices_[i].device + ".yaml"),
                 device_of(joint, i));
  }
}

std::vector<std::filesystem::path> LearnedNetworks::write(const std::filesystem::path& joint,
                                                          const std::filesystem::path& folder,
                                                          const nn::ModelCard& card) {
  const auto numbers = nn::WeightsFile::read(joint);
  std::vector<std::filesystem::path> files;
  for (const Part& part : parts_) {
    nn::ModelCard own = card;
    own.what = part.card.what;
    own.data = part.card.data.empty() ? card.data : part.card.data + "; then " + card.data;
    own.parent = part.card.sha256;
    own.limits = card.limits;
    own.sha256.clear();
    files.push_back(folder / (part.name + ".safetensors"));
    if (part.name == kMatch) write_network(kMatch, *match_, numbers, files.back(), own);
    if (part.name == kNoise) write_network(kNoise, *noise_, numbers, files.back(), own);
    if (part.name == kHead) write_network(kHead, *head_, numbers, files.back(), own);
    if (part.name == kImu) write_network(kImu, *imu_, numbers, files.back(), own);
  }
  write_devices(numbers, folder);
  return files;
}

std::vector<std::string> network_assignments(const std::filesystem::path& folder) {
  std::vector<std::string> assignments;
  const auto use = [&](const std::string& name, const char* key) {
    const auto file = folder / name;
    if (std::filesystem::exists(file)) assignments.push_back(key + ("=" + file.string()));
  };
  constexpr const char* kSuffix = ".safetensors";
  use(std::string(kMatch) + kSuffix, "vo.learned.weights");
  use(std::string(kNoise) + kSuffix, "vo.motion_noise");
  use(std::string(kHead) + kSuffix, "vo.regression.weights");
  use(std::string(kImu) + kSuffix, "imu_network.weights");
  const bool networks = !assignments.empty();
  use(kDeviceFile, "system.device");
  use(kDeviceFolder, "system.device");
  if (!networks) {
    throw InputError(folder.string() +
                         ": no network here; expected the weights folder of a fine-tuning "
                         "(match_network, motion_noise, pose_head, imu_network .safetensors)",
                     ExitCode::kModel);
  }
  return assignments;
}

void use_networks(const std::filesystem::path& folder, system::SlamOptions& slam) {
  Config config;
  slam.describe(config);
  for (const std::string& assignment : network_assignments(folder)) {
    config.set(assignment, "networks");
  }
}

}  // namespace imslam::adaptation
