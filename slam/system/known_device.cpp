#include "slam/system/known_device.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <filesystem>
#include <optional>

namespace imslam::system {
namespace {

/// Between recordings the rig warms up and is knocked about.
constexpr double kDisparityOffsetSigma_px = 0.1;

std::string fingerprint_of(const datasets::Sequence& sequence) {
  std::optional<ImuNoise> noise;
  if (sequence.imu()) noise = sequence.imu()->noise;
  return device_fingerprint(sequence.camera(), noise);
}

/// All but what is known of the camera.
DeviceCalibration without_camera(DeviceCalibration device) {
  const DeviceCalibration nothing;
  device.focal_error = nothing.focal_error;
  device.disparity_offset_px = nothing.disparity_offset_px;
  device.camera_rotation = nothing.camera_rotation;
  return device;
}

}  // namespace

DeviceCalibration known_device(const SlamOptions& options,
                               const datasets::Sequence& sequence,
                               std::string& why_not) {
  why_not.clear();
  if (options.system.device.empty()) return {};
  const std::string present = fingerprint_of(sequence);
  std::filesystem::path file = options.system.device;
  if (std::filesystem::is_directory(file)) file /= present + ".yaml";
  if (file != options.system.device && !std::filesystem::exists(file)) {
    why_not = fmt::format("{} knows nothing of this device ({})", options.system.device, present);
    return {};
  }
  const DeviceCalibration device = read_device(file);
  if (!device.device.empty() && device.device != present) {
    why_not =
        fmt::format("{} is of another device ({}, this one is {}): its calibration is not used",
                    options.system.device, device.device, present);
    return {};
  }
  if (device.head.empty() || device.head == options.vo.head) return device;
  why_not =
      fmt::format("{}: the camera's numbers were learned with vo.head={} and are not used with {}",
                  file.string(), device.head, options.vo.head);
  return without_camera(device);
}

DeviceCalibration present_device(const SlamOptions& options, const datasets::Sequence& sequence) {
  std::string why_not;
  DeviceCalibration device = known_device(options, sequence, why_not);
  device.device = fingerprint_of(sequence);
  device.head = options.vo.head;
  return device;
}

SlamOptions with_device(const SlamOptions& options, const DeviceCalibration& device) {
  SlamOptions known = options;
  if (device.disparity_offset_px != 0.0) {
    known.vo.offset.prior = device.disparity_offset_px;
    known.vo.offset.prior_sigma = std::min(known.vo.offset.prior_sigma, kDisparityOffsetSigma_px);
    known.vo.offset.exact = 0.0;  // this camera is known to be one of the others
  }
  if (device.time_offset_s != 0.0) known.system.time_offset_s = device.time_offset_s;
  return known;
}

}  // namespace imslam::system
