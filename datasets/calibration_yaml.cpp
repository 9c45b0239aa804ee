#include "datasets/calibration_yaml.hpp"

#include <fmt/format.h>

#include <cmath>

#include "slam/base/error.hpp"
#include "slam/base/log.hpp"

namespace imslam::datasets {
namespace {

void read_size(const YamlValue& value, RawCamera& camera) {
  const auto size = value.numbers(2);
  camera.width = whole_pixels(value, size[0]);
  camera.height = whole_pixels(value, size[1]);
}

void read_intrinsics(const YamlValue& value, RawCamera& camera) {
  const auto numbers = value.numbers(4);
  camera.fx = numbers[0];
  camera.fy = numbers[1];
  camera.cx = numbers[2];
  camera.cy = numbers[3];
  camera.where = value.where();
}

void expect_pinhole(const YamlValue& map) {
  if (!map.has("camera_model")) return;
  const YamlValue model = map.at("camera_model");
  if (model.text() != "pinhole") {
    model.fail("pinhole, found '" + model.text() + "'; calibrate again with the pinhole model");
  }
}

RawCamera kalibr_camera(const YamlValue& map) {
  RawCamera camera;
  expect_pinhole(map);
  read_size(map.at("resolution"), camera);
  read_intrinsics(map.at("intrinsics"), camera);
  camera.lens = lens_model(map.at("distortion_model").text(), map.at("distortion_model").where());
  if (camera.lens != LensModel::kNone) camera.distortion = map.at("distortion_coeffs").numbers();
  return camera;
}

lie::SE3d rigid_motion_at(const YamlValue& map, const std::string& key) {
  const YamlValue value = map.at(key);
  return rigid_motion(value.matrix4(), value.where());
}

}  // namespace

int whole_pixels(const YamlValue& value, double number) {
  if (!(number >= 0 && number <= 1e6) || number != std::floor(number)) {
    value.fail("[width, height] in whole pixels");
  }
  return static_cast<int>(number);
}

RawCamera read_euroc_camera(const std::filesystem::path& sensor_yaml) {
  const YamlValue map = load_yaml(sensor_yaml);
  RawCamera camera;
  expect_pinhole(map);
  read_size(map.at("resolution"), camera);
  read_intrinsics(map.at("intrinsics"), camera);
  const YamlValue model = map.at("distortion_model");
  camera.lens = lens_model(model.text(), model.where());
  if (camera.lens != LensModel::kNone) {
    camera.distortion = map.at("distortion_coefficients").numbers();
  }
  camera.T_body_camera = rigid_motion_at(map, "T_BS");
  camera.where_it_stands = map.at("T_BS").where();
  return camera;
}

lie::SE3d read_euroc_extrinsics(const std::filesystem::path& sensor_yaml) {
  return rigid_motion_at(load_yaml(sensor_yaml), "T_BS");
}

ImuNoise imu_noise(const YamlValue& map) {
  ImuNoise noise;
  const auto read = [&map](const std::string& key, double& value) {
    if (!map.has(key)) return;
    value = map.at(key).number();
    if (!(value > 0.0 && value < 1e6)) map.at(key).fail("a positive number");
  };
  read("gyroscope_noise_density", noise.gyro_noise_density);
  read("gyroscope_random_walk", noise.gyro_random_walk);
  read("accelerometer_noise_density", noise.accel_noise_density);
  read("accelerometer_random_walk", noise.accel_random_walk);
  read("update_rate", noise.rate_hz);
  read("rate_hz", noise.rate_hz);
  read("gyroscope_range", noise.gyro_range);
  read("accelerometer_range", noise.accel_range);
  return noise;
}

KalibrChain read_kalibr_chain(const std::filesystem::path& camchain_yaml) {
  const YamlValue root = load_yaml(camchain_yaml);
  const YamlValue map0 = root.at("cam0");
  const YamlValue map1 = root.at("cam1");
  KalibrChain chain;
  chain.cam0 = kalibr_camera(map0);
  chain.cam1 = kalibr_camera(map1);
  chain.has_imu = map0.has("T_cam_imu");
  if (chain.has_imu) chain.cam0.T_body_camera = rigid_motion_at(map0, "T_cam_imu").inverse();
  if (map1.has("T_cn_cnm1")) {
    chain.cam1.T_body_camera =
        chain.cam0.T_body_camera * rigid_motion_at(map1, "T_cn_cnm1").inverse();
  } else {
    chain.cam1.T_body_camera = rigid_motion_at(map1, "T_cam_imu").inverse();
  }
  if (map0.has("timeshift_cam_imu")) {
    chain.timeshift_s = map0.at("timeshift_cam_imu").number();
    if (std::abs(chain.timeshift_s) > 1.0) map0.at("timeshift_cam_imu").fail("at most one second");
  }
  return chain;
}

ImuNoise read_kalibr_imu(const std::filesystem::path& imu_yaml) {
  const YamlValue root = load_yaml(imu_yaml);
  return imu_noise(root.has("imu0") ? root.at("imu0") : root);
}

}  // namespace imslam::datasets
