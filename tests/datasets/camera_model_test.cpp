#include "datasets/camera_model.hpp"

#include <gtest/gtest.h>

#include <limits>

#include "datasets/calibration_yaml.hpp"
#include "tests/datasets/expect_error.hpp"
#include "tests/support/temp_dir.hpp"

namespace imslam::datasets {
namespace {

using imslam::testing::expect_input_error;
using imslam::testing::TempDir;

RawCamera good_camera() {
  RawCamera camera;
  camera.width = 752;
  camera.height = 480;
  camera.fx = camera.fy = 458.0;
  camera.cx = 367.0;
  camera.cy = 248.0;
  camera.lens = LensModel::kRadialTangential;
  camera.distortion = {0, 0, 0, 0};
  camera.where = "c.yaml:7";
  return camera;
}

TEST(ValidateCamera, AcceptsAnOrdinaryCamera) { EXPECT_NO_THROW(validate(good_camera())); }

TEST(ValidateCamera, RefusesImpossibleNumbers) {
  const auto refuse = [](auto&& change, const std::string& word) {
    RawCamera camera = good_camera();
    change(camera);
    expect_input_error([&] { validate(camera); }, ExitCode::kCalibration, {"c.yaml:7", word});
  };
  refuse([](RawCamera& c) { c.width = 0; }, "0x480");
  refuse([](RawCamera& c) { c.height = 100000; }, "752x100000");
  refuse([](RawCamera& c) { c.fx = 0; }, "focal length 0");
  refuse([](RawCamera& c) { c.fy = -458; }, "focal length -458");
  refuse([](RawCamera& c) { c.fx = std::numeric_limits<double>::quiet_NaN(); }, "focal length nan");
  refuse([](RawCamera& c) { c.fx = 1.0; }, "focal length 1 ");
  refuse([](RawCamera& c) { c.fx = 200; }, "differ too much");
  refuse([](RawCamera& c) { c.cx = 800; }, "principal point");
  refuse([](RawCamera& c) { c.distortion = {1e-4, 2e-5, -0.28, 0.07}; }, "k1 k2 p1 p2");
  refuse([](RawCamera& c) { c.distortion = {0, 0, 0}; }, "3 distortion coefficients");
  refuse([](RawCamera& c) { c.lens = LensModel::kEquidistant, c.distortion.resize(5); },
         "5 distortion coefficients");
}

TEST(RigidMotion, RefusesWhatIsNoRotation) {
  const auto refuse = [](const Eigen::Matrix4d& M, const std::string& word) {
    expect_input_error([&] { rigid_motion(M, "f:2"); }, ExitCode::kCalibration, {"f:2", word});
  };
  Eigen::Matrix4d M = Eigen::Matrix4d::Identity();
  EXPECT_NO_THROW(rigid_motion(M, "f:2"));
  M(0, 0) = 1.0004;
  EXPECT_NO_THROW(rigid_motion(M, "f:2"));
  M(0, 0) = 1.001;
  refuse(M, "no rotation");
  M(0, 0) = -1.0;
  refuse(M, "mirror");
  M = Eigen::Matrix4d::Identity();
  M(3, 0) = 0.1;
  refuse(M, "transposed");
  M = Eigen::Matrix4d::Identity();
  M(1, 3) = 110.0;
  refuse(M, "millimetres");
  M(1, 3) = std::numeric_limits<double>::infinity();
  refuse(M, "finite");
}

constexpr const char* kSensorYaml = R"(%YAML:1.0
T_BS:
  cols: 4
  rows: 4
  data: [0, 0, 1, 0.1,  -1, 0, 0, 0.2,  0, -1, 0, 0.3,  0, 0, 0, 1]
resolution: [752, 480]
camera_model: pinhole
intrinsics: [458.6, 457.2, 367.2, 248.3]
distortion_model: radial-tangential
distortion_coefficients: [-0.28, 0.07, 0.0002, 1.7e-05]
)";

TEST(EurocCamera, ReadsEveryValue) {
  const TempDir dir;
  const RawCamera camera = read_euroc_camera(dir.write("sensor.yaml", kSensorYaml));
  EXPECT_EQ(camera.width, 752);
  EXPECT_EQ(camera.height, 480);
  EXPECT_EQ(camera.fx, 458.6);
  EXPECT_EQ(camera.cy, 248.3);
  EXPECT_EQ(camera.lens, LensModel::kRadialTangential);
  EXPECT_EQ(camera.distortion, (std::vector<double>{-0.28, 0.07, 0.0002, 1.7e-05}));
  EXPECT_EQ(camera.T_body_camera.translation(), Eigen::Vector3d(0.1, 0.2, 0.3));
  EXPECT_LT(
      (camera.T_body_camera * Eigen::Vector3d(0, 0, 1) - Eigen::Vector3d(1.1, 0.2, 0.3)).norm(),
      1e-12);
}

TEST(EurocCamera, NamesLineAndKeyOfWhatIsWrong) {
  const TempDir dir;
  const auto refuse = [&](const std::string& from, const std::string& to,
                          const std::vector<std::string>& words) {
    std::string text = kSensorYaml;
    text.replace(text.find(from), from.size(), to);
    expect_input_error([&] { read_euroc_camera(dir.write("sensor.yaml", text)); },
                       ExitCode::kCalibration, words);
  };
  refuse("intrinsics:", "intrinsic:", {"sensor.yaml", "'intrinsics'", "spelled 'intrinsic'"});
  refuse("367.2, 248.3", "367.2", {"sensor.yaml:8", "intrinsics", "4 numbers, found 3"});
  refuse("458.6", "nan", {"sensor.yaml:8", "finite"});
  refuse("458.6", "458,6", {"sensor.yaml:8", "4 numbers, found 5"});
  refuse("pinhole", "omni", {"sensor.yaml:7", "pinhole", "'omni'"});
  refuse("radial-tangential", "magic", {"sensor.yaml:9", "'magic'"});
  refuse("[752, 480]", "[752.5, 480]", {"sensor.yaml:6", "whole pixels"});
  refuse("0.1,  -1", "0.1,  -2", {"sensor.yaml:3", "no rotation"});
  refuse("0, 0, 0, 1]", "0, 0, 0]", {"sensor.yaml:5", "16 numbers, found 15"});
  refuse("[752, 480]", "[752, 480", {"sensor.yaml:", "not valid YAML"});
  expect_input_error([&] { read_euroc_camera(dir.path() / "none.yaml"); }, ExitCode::kCalibration,
                     {"none.yaml", "cannot be opened"});
}

constexpr const char* kCamchain = R"(cam0:
  T_cam_imu:
  - [0, -1, 0, 0.01]
  - [0, 0, -1, 0.02]
  - [1, 0, 0, 0.03]
  - [0, 0, 0, 1]
  cam_overlaps: [1]
  camera_model: pinhole
  distortion_coeffs: [0.0034, 0.0007, -0.002, 0.0002]
  distortion_model: equidistant
  intrinsics: [190.9, 190.9, 254.9, 256.8]
  resolution: [512, 512]
  rostopic: /cam0/image_raw
  timeshift_cam_imu: -0.003
cam1:
  T_cn_cnm1:
  - [1, 0, 0, -0.1]
  - [0, 1, 0, 0]
  - [0, 0, 1, 0]
  - [0, 0, 0, 1]
  camera_model: pinhole
  distortion_coeffs: [0.003, 0.001, -0.002, 0.0002]
  distortion_model: equidistant
  intrinsics: [190.4, 190.4, 252.5, 254.9]
  resolution: [512, 512]
)";

TEST(KalibrChain, InvertsTheExtrinsicsAndChainsTheCameras) {
  const TempDir dir;
  const KalibrChain chain = read_kalibr_chain(dir.write("camchain-imucam.yaml", kCamchain));
  EXPECT_TRUE(chain.has_imu);
  EXPECT_EQ(chain.timeshift_s, -0.003);
  EXPECT_EQ(chain.cam0.lens, LensModel::kEquidistant);
  // T_cam_imu puts the IMU's origin at (0.01, 0.02, 0.03) of the camera.
  EXPECT_LT((chain.cam0.T_body_camera * Eigen::Vector3d(0.01, 0.02, 0.03)).norm(), 1e-12);
  // T_cn_cnm1 with -0.1: cam1 stands 0.1 m to the right of cam0.
  const auto T_cam0_cam1 = chain.cam0.T_body_camera.inverse() * chain.cam1.T_body_camera;
  EXPECT_LT((T_cam0_cam1.translation() - Eigen::Vector3d(0.1, 0, 0)).norm(), 1e-12);
}

TEST(ImuNoiseFile, ReadsKalibrAndRefusesWhatIsNotPositive) {
  const TempDir dir;
  const std::string keys =
      "accelerometer_noise_density: 0.0028\naccelerometer_random_walk: 0.00086\n"
      "gyroscope_noise_density: 0.00016\ngyroscope_random_walk: 0.000022\nupdate_rate: 200.0\n";
  const ImuNoise noise = read_kalibr_imu(dir.write("imu.yaml", keys));
  EXPECT_EQ(noise.accel_noise_density, 0.0028);
  EXPECT_EQ(noise.gyro_random_walk, 0.000022);
  EXPECT_EQ(noise.rate_hz, 200.0);
  const ImuNoise nested = read_kalibr_imu(dir.write("imu2.yaml", "imu0:\n  update_rate: 100\n"));
  EXPECT_EQ(nested.rate_hz, 100.0);
  expect_input_error(
      [&] { read_kalibr_imu(dir.write("bad.yaml", "gyroscope_noise_density: -1\n")); },
      ExitCode::kCalibration, {"bad.yaml:1", "gyroscope_noise_density", "positive"});
}

TEST(ParseYaml, SurvivesHostileText) {
  for (const std::string& text :
       {std::string(100000, '['), std::string("a: &a [*a, *a]\nb: *a"), std::string("\0\0\0", 3),
        std::string("- - - - : {"), std::string("!!binary |\n  x"), std::string("%YAML:1.0\n---\n"),
        std::string("key: !!opencv-matrix\n  rows: 4\n  data: [1"), std::string()}) {
    try {
      const YamlValue root = parse_yaml(text, "t.yaml");
      expect_input_error([&] { root.at("T_BS").matrix4(); }, ExitCode::kCalibration, {"t.yaml"});
    } catch (const InputError& error) {
      EXPECT_EQ(error.code(), ExitCode::kCalibration);
    }
  }
}

}  // namespace
}  // namespace imslam::datasets
