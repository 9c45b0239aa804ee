#pragma once

#include <filesystem>
#include <optional>

#include "datasets/camera_model.hpp"
#include "datasets/yaml_file.hpp"
#include "slam/sensors/imu.hpp"

namespace imslam::datasets {

/// A camera's `sensor.yaml` of the EuRoC (ASL) layout; T_BS carries points from camera to body.
RawCamera read_euroc_camera(const std::filesystem::path& sensor_yaml);

/// T_BS of any `sensor.yaml`: carries points from the sensor to the body.
lie::SE3d read_euroc_extrinsics(const std::filesystem::path& sensor_yaml);

/// Noise densities, random walks and rate from a map with the keys of EuRoC's imu0/sensor.yaml or
/// Kalibr's imu.yaml (they share them but for rate_hz / update_rate). Keys that are absent keep
/// their default; InputError(kCalibration) if one is not positive.
ImuNoise imu_noise(const YamlValue& map);

/// `number` as a count of pixels; the error names `value`.
int whole_pixels(const YamlValue& value, double number);

/// Both cameras of a Kalibr camchain. T_cam_imu carries points from IMU to camera (the inverse of
/// T_body_camera); without it the left camera is the body.
struct KalibrChain {
  RawCamera cam0;
  RawCamera cam1;
  bool has_imu = false;      ///< T_cam_imu was given
  double timeshift_s = 0.0;  ///< [s] t_imu = t_camera + timeshift
};
KalibrChain read_kalibr_chain(const std::filesystem::path& camchain_yaml);

/// Kalibr's imu.yaml: the keys at the top or under `imu0`.
ImuNoise read_kalibr_imu(const std::filesystem::path& imu_yaml);

}  // namespace imslam::datasets
