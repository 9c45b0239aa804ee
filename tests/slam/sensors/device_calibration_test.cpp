#include "slam/sensors/device_calibration.hpp"

#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <string>

#include "slam/base/error.hpp"
#include "tests/support/temp_dir.hpp"

namespace imslam {
namespace {

StereoCamera camera() {
  StereoCamera camera;
  camera.width = 640;
  camera.height = 480;
  camera.fx = camera.fy = 400.0;
  camera.cx = 320.0;
  camera.cy = 240.0;
  camera.baseline_m = 0.1;
  camera.T_body_left = {lie::SO3d::exp({0.1, -0.2, 1.5}), Eigen::Vector3d(0.01, 0.02, 0.03)};
  return camera;
}

TEST(DeviceCalibration, AFocalErrorScalesRaysButNotTheLawOfDepth) {
  DeviceCalibration device;
  device.focal_error = 0.03;
  const StereoCamera stated = camera();
  const StereoCamera truth = calibrated(stated, device);
  EXPECT_DOUBLE_EQ(truth.fx, 412.0);
  EXPECT_DOUBLE_EQ(truth.fy, 412.0);
  const Eigen::Vector3d seen(400.0, 200.0, 8.0);
  EXPECT_NEAR(truth.back_project(seen).z(), stated.back_project(seen).z(), 1e-12);
  EXPECT_NEAR(truth.back_project(seen).x(), stated.back_project(seen).x() / 1.03, 1e-12);
}

TEST(DeviceCalibration, TurnsTheCameraAgainstTheBodyWhereItStands) {
  DeviceCalibration device;
  device.camera_rotation = {0.01, 0.0, -0.02};
  const lie::SE3d T = calibrated(camera(), device).T_body_left;
  const auto turn = camera().T_body_left.rotation().inverse() * T.rotation();
  EXPECT_LT((turn.log() - device.camera_rotation).norm(), 1e-12);
  EXPECT_EQ(T.translation(), camera().T_body_left.translation());
}

TEST(DeviceCalibration, KeepsWithinWhatIsPossible) {
  DeviceCalibration device;
  device.focal_error = -0.5;
  device.camera_rotation.y() = 1.0;
  device.time_offset_s = 0.01;
  const DeviceCalibration kept = within_bounds(device);
  EXPECT_EQ(kept.focal_error, -DeviceBounds::kFocalError);
  EXPECT_EQ(kept.camera_rotation.y(), DeviceBounds::kCameraRotation);
  EXPECT_EQ(kept.time_offset_s, 0.01);
}

TEST(DeviceFingerprint, TellsOtherFilesFromTheSame) {
  const ImuNoise noise;
  ImuNoise noisier;
  noisier.gyro_noise_density *= 2.0;
  StereoCamera other = camera();
  other.fx += 0.5;
  const std::string same = device_fingerprint(camera(), noise);
  EXPECT_EQ(same.size(), 16U);
  EXPECT_EQ(same, device_fingerprint(camera(), noise));
  EXPECT_NE(same, device_fingerprint(camera(), noisier));
  EXPECT_NE(same, device_fingerprint(other, noise));
  EXPECT_NE(same, device_fingerprint(camera(), std::nullopt));
}

TEST(DeviceFile, GivesBackWhatWasWritten) {
  const testing::TempDir folder;
  const auto file = folder.path() / "device.yaml";
  DeviceCalibration device;
  device.device = "0123456789abcdef";
  device.head = "regression";
  device.focal_error = 1.0 / 300.0;
  device.disparity_offset_px = -0.15;
  device.time_offset_s = 0.0051;
  device.camera_rotation = {0.001, -0.002, 0.003};
  device.reading_offset.gyro = {1e-3, 2e-3, -3e-3};
  device.reading_offset.accel = {0.1, 0.2, 0.3};
  write_device(file, device);
  const DeviceCalibration read = read_device(file);
  EXPECT_EQ(read.device, device.device);
  EXPECT_EQ(read.head, device.head);
  EXPECT_EQ(read.focal_error, device.focal_error);
  EXPECT_EQ(read.disparity_offset_px, device.disparity_offset_px);
  EXPECT_EQ(read.time_offset_s, device.time_offset_s);
  EXPECT_EQ(read.camera_rotation, device.camera_rotation);
  EXPECT_EQ(read.reading_offset.gyro, device.reading_offset.gyro);
  EXPECT_EQ(read.reading_offset.accel, device.reading_offset.accel);
}

TEST(DeviceFile, AnImpossibleCalibrationIsRefusedWithItsFile) {
  const testing::TempDir folder;
  const auto file = folder.path() / "device.yaml";
  for (const char* line : {"focal_error: 0.4", "time_offset_s: .nan", "focal: 0.01"}) {
    std::ofstream(file) << "device:\n  " << line << "\n";
    try {
      read_device(file);
      FAIL() << line;
    } catch (const InputError& error) {
      EXPECT_EQ(error.code(), ExitCode::kUsage);
      EXPECT_NE(std::string(error.what()).find("device.yaml"), std::string::npos) << error.what();
    }
  }
}

}  // namespace
}  // namespace imslam
