#pragma once

#include <Eigen/Core>
#include <filesystem>
#include <optional>
#include <string>

#include "slam/sensors/calibration.hpp"
#include "slam/sensors/imu.hpp"

namespace imslam {

class Config;

/// What one individual device has beside what its calibration files state: learned from its own
/// recordings, of no use to any other device. Zero: it is as stated.
struct DeviceCalibration {
  std::string device;        ///< device_fingerprint() that it belongs to; empty: any
  std::string head;          ///< what made motions of matches when it was learned; empty: any
  double focal_error = 0.0;  ///< [1] fx, fy are (1 + focal_error) of the stated; fx baseline holds
  double disparity_offset_px = 0.0;  ///< measured = true + offset
  double time_offset_s = 0.0;        ///< stamp of the IMU = stamp of the camera + offset
  /// [rad] true R_body_left = stated Exp(camera_rotation).
  Eigen::Vector3d camera_rotation = Eigen::Vector3d::Zero();
  /// Constant errors of the readings, for the IMU network.
  ImuBias reading_offset;

  void describe(Config& config);
};

/// Largest corrections that are taken for possible; beyond them the calibration is plainly wrong.
struct DeviceBounds {
  static constexpr double kFocalError = 0.05;         // [1]
  static constexpr double kDisparityOffset_px = 3.0;  // [px]
  static constexpr double kTimeOffset_s = 0.1;        // [s]
  static constexpr double kCameraRotation = 0.0524;   // [rad], 3 degrees, about each axis
};

/// The same, each number no farther from zero than DeviceBounds; readings as they are.
DeviceCalibration within_bounds(DeviceCalibration calibration);

/// The camera as it is in truth.
StereoCamera calibrated(const StereoCamera& stated, const DeviceCalibration& device);

/// Tells devices apart by what their calibration files state (stereo camera, extrinsics, noise of
/// the IMU): sixteen hexadecimal digits. Two devices with the same files look alike.
std::string device_fingerprint(const StereoCamera& stated, const std::optional<ImuNoise>& noise);

/// A file that write_device() made, or one by hand: a YAML section `device`. Throws
/// InputError(kUsage) "file:line: ..." for anything else.
DeviceCalibration read_device(const std::filesystem::path& file);
/// Throws InputError(kOutput).
void write_device(const std::filesystem::path& file, const DeviceCalibration& device);

}  // namespace imslam
