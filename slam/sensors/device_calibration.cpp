#include "slam/sensors/device_calibration.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "slam/base/config.hpp"
#include "slam/base/error.hpp"
#include "slam/base/file.hpp"

namespace imslam {
namespace {

constexpr std::size_t kFingerprintDigits = 16;
constexpr const char* kAxes[3] = {"x", "y", "z"};

void describe_vector(Config& config,
                     const std::string& name,
                     Eigen::Vector3d& value,
                     const std::string& help) {
  for (int axis = 0; axis < 3; ++axis) {
    config.field(name + "_" + kAxes[axis], value[axis], help);
  }
}

double clamped(double value, double bound) { return std::clamp(value, -bound, bound); }

bool is_possible(const DeviceCalibration& c) {
  const DeviceCalibration in = within_bounds(c);
  return in.focal_error == c.focal_error && in.disparity_offset_px == c.disparity_offset_px &&
         in.time_offset_s == c.time_offset_s && in.camera_rotation == c.camera_rotation &&
         c.reading_offset.gyro.allFinite() && c.reading_offset.accel.allFinite();
}

}  // namespace

void DeviceCalibration::describe(Config& config) {
  config.field("device", device, "fingerprint of the device it belongs to; empty: any");
  config.field("head", head, "vo.head that the camera's numbers were learned with; empty: any");
  config.field("focal_error", focal_error, "[1] true over stated focal length, less 1");
  config.field("disparity_offset_px", disparity_offset_px, "[px] measured less true disparity");
  config.field("time_offset_s", time_offset_s, "[s] stamp of the IMU less that of the camera");
  describe_vector(config, "camera_rotation", camera_rotation,
                  "[rad] true R_body_left = stated Exp(this)");
  describe_vector(config, "gyro_offset", reading_offset.gyro, "[rad/s] for the IMU network");
  describe_vector(config, "accel_offset", reading_offset.accel, "[m/s^2] for the IMU network");
}

DeviceCalibration within_bounds(DeviceCalibration calibration) {
  DeviceCalibration& c = calibration;
  c.focal_error = clamped(c.focal_error, DeviceBounds::kFocalError);
  c.disparity_offset_px = clamped(c.disparity_offset_px, DeviceBounds::kDisparityOffset_px);
  c.time_offset_s = clamped(c.time_offset_s, DeviceBounds::kTimeOffset_s);
  for (int axis = 0; axis < 3; ++axis) {
    c.camera_rotation[axis] = clamped(c.camera_rotation[axis], DeviceBounds::kCameraRotation);
  }
  return calibration;
}

StereoCamera calibrated(const StereoCamera& stated, const DeviceCalibration& device) {
  StereoCamera camera = stated;
  camera.fx *= 1.0 + device.focal_error;
  camera.fy *= 1.0 + device.focal_error;
  camera.baseline_m /= 1.0 + device.focal_error;
  camera.T_body_left = {stated.T_body_left.rotation() * lie::SO3d::exp(device.camera_rotation),
                        stated.T_body_left.translation()};
  return camera;
}

std::string device_fingerprint(const StereoCamera& stated, const std::optional<ImuNoise>& noise) {
  const auto& T = stated.T_body_left;
  const Eigen::Matrix3d R = T.rotation().matrix();
  std::string text =
      fmt::format("{} {} {:.6f} {:.6f} {:.6f} {:.6f} {:.8f}", stated.width, stated.height,
                  stated.fx, stated.fy, stated.cx, stated.cy, stated.baseline_m);
  for (int i = 0; i < 9; ++i) text += fmt::format(" {:.6f}", R(i / 3, i % 3));
  for (int i = 0; i < 3; ++i) text += fmt::format(" {:.6f}", T.translation()[i]);
  if (noise) {
    text += fmt::format(" {:.6e} {:.6e} {:.6e} {:.6e} {:.3f}", noise->gyro_noise_density,
                        noise->gyro_random_walk, noise->accel_noise_density,
                        noise->accel_random_walk, noise->rate_hz);
  }
  return sha256(text).substr(0, kFingerprintDigits);
}

DeviceCalibration read_device(const std::filesystem::path& file) {
  DeviceCalibration device;
  Config config;
  config.section("device", device);
  config.load_file(file);
  if (is_possible(device)) return device;
  throw InputError(
      fmt::format("{}: a calibration farther from the stated one than is possible (focal error "
                  "{}, disparity offset {} px, time offset {} s, camera rotation {} rad about an "
                  "axis); calibrate the device anew",
                  file.string(), DeviceBounds::kFocalError, DeviceBounds::kDisparityOffset_px,
                  DeviceBounds::kTimeOffset_s, DeviceBounds::kCameraRotation),
      ExitCode::kUsage);
}

void write_device(const std::filesystem::path& file, const DeviceCalibration& device) {
  DeviceCalibration copy = device;
  Config config;
  config.section("device", copy);
  write_file_atomic(file, config.to_yaml(true));
}

}  // namespace imslam
