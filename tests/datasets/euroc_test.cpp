#include "datasets/euroc.hpp"

#include <gtest/gtest.h>

#include "datasets/open_sequence.hpp"
#include "slam/base/file.hpp"
#include "tests/datasets/expect_error.hpp"
#include "tests/support/numeric_jacobian.hpp"
#include "tests/support/temp_dir.hpp"
#include "tests/support/test_data.hpp"
#include "tests/support/tiny_dataset.hpp"

namespace imslam::datasets {
namespace {

namespace fs = std::filesystem;
using imslam::testing::euroc_camera_yaml;
using imslam::testing::expect_input_error;
using imslam::testing::expect_near;
using imslam::testing::matrix_text;
using imslam::testing::TempDir;
using imslam::testing::TinyWorld;
using imslam::testing::write_text;
using imslam::testing::write_tiny_euroc;

TinyWorld small_world() {
  TinyWorld world;
  world.frames = 6;
  return world;
}

void replace(const fs::path& file, const std::string& from, const std::string& to) {
  std::string text = read_file(file);
  const auto at = text.find(from);
  ASSERT_NE(at, std::string::npos) << from;
  write_text(file, text.replace(at, from.size(), to));
}

class TinyEuroc : public ::testing::Test {
 protected:
  TinyEuroc() { write_tiny_euroc(dir_.path(), world_); }
  fs::path mav0() const { return dir_.path() / "mav0"; }
  std::unique_ptr<Sequence> open() const { return open_sequence(dir_.path()); }

  const TinyWorld world_ = small_world();
  const TempDir dir_;
};

TEST_F(TinyEuroc, OpensFromTheFolderAndFromMav0) {
  for (const fs::path& folder : {dir_.path(), mav0(), mav0() / ""}) {
    const auto sequence = open_sequence(folder);
    EXPECT_EQ(sequence->format(), "euroc");
    EXPECT_EQ(sequence->name(), dir_.path().filename().string());
    EXPECT_EQ(sequence->frame_count(), 6U);
    EXPECT_EQ(sequence->frame_time_ns(1), world_.frame_time_ns(1));
  }
}

TEST_F(TinyEuroc, KeepsAnUndistortedPairAndItsGeometry) {
  const auto sequence = open();
  const StereoCamera& camera = sequence->camera();
  EXPECT_NEAR(camera.baseline_m, world_.baseline_m, 1e-12);
  EXPECT_NEAR(camera.fx, world_.f, 2.0);
  expect_near(camera.T_body_left.matrix(), world_.T_body_left().matrix(), 1e-9);
  const StereoFrame frame = sequence->read_frame(2);
  EXPECT_EQ(frame.index, 2U);
  EXPECT_EQ(frame.time_ns, world_.frame_time_ns(2));
  EXPECT_TRUE(frame.complete());
  EXPECT_EQ(frame.left.width, 320);
  EXPECT_EQ(frame.right.height, 240);
}

TEST_F(TinyEuroc, ReadsImuWithNoiseAndTruth) {
  const auto sequence = open();
  ASSERT_TRUE(sequence->imu());
  EXPECT_EQ(sequence->imu()->samples.size(), world_.imu().size());
  EXPECT_EQ(sequence->imu()->samples[3].linear_acceleration, world_.imu()[3].linear_acceleration);
  EXPECT_EQ(sequence->imu()->noise.gyro_noise_density, 1.0e-4);
  ASSERT_TRUE(sequence->truth());
  EXPECT_EQ(sequence->truth()->size(), 6U);
  EXPECT_EQ(sequence->truth()->frame, "body");
  expect_near(sequence->T_body_truth().matrix(), Eigen::Matrix4d::Identity(), 1e-15);
  expect_near(sequence->truth()->poses[4], world_.T_world_body(4 / 20.0).matrix(), 1e-12);
}

TEST_F(TinyEuroc, MovesTheBodyToTheImu) {
  const lie::SE3d T_base_imu(lie::SO3d::exp(Eigen::Vector3d(0.1, 0.2, -1.0)),
                             Eigen::Vector3d(0.3, 0.1, -0.2));
  replace(mav0() / "imu0" / "sensor.yaml", matrix_text(Eigen::Matrix4d::Identity()),
          matrix_text(T_base_imu.matrix()));
  const auto sequence = open();
  expect_near(sequence->camera().T_body_left.matrix(),
              (T_base_imu.inverse() * world_.T_body_left()).matrix(), 1e-9);
  expect_near(sequence->T_body_truth().matrix(), T_base_imu.inverse().matrix(), 1e-12);
}

TEST_F(TinyEuroc, WithoutImuTheLeftCameraIsTheBody) {
  fs::remove_all(mav0() / "imu0");
  const auto sequence = open();
  EXPECT_FALSE(sequence->imu());
  expect_near(sequence->camera().T_body_left.matrix(), Eigen::Matrix4d::Identity(), 1e-15);
  // T_world_left = truth * T_truth_left
  expect_near(sequence->T_body_truth().inverse().matrix(), world_.T_body_left().matrix(), 1e-9);
}

TEST_F(TinyEuroc, KeepsThePlaceOfMissingAndDamagedImages) {
  const auto name = [&](int i) { return std::to_string(world_.frame_time_ns(i)) + ".png"; };
  replace(mav0() / "cam1" / "data.csv",
          std::to_string(world_.frame_time_ns(1)) + "," + name(1) + "\n", "");
  replace(mav0() / "cam0" / "data.csv",
          std::to_string(world_.frame_time_ns(2)) + "," + name(2) + "\n", "");
  fs::remove(mav0() / "cam0" / "data" / name(3));
  write_text(mav0() / "cam1" / "data" / name(4), "not an image");
  const auto sequence = open();
  ASSERT_EQ(sequence->frame_count(), 6U);
  const std::pair<bool, bool> expected[] = {{true, true},  {true, false}, {false, true},
                                            {false, true}, {true, false}, {true, true}};
  for (std::size_t i = 0; i < 6; ++i) {
    const StereoFrame frame = sequence->read_frame(i);
    EXPECT_EQ(frame.time_ns, world_.frame_time_ns(static_cast<int>(i)));
    EXPECT_EQ(!frame.left.empty(), expected[i].first) << i;
    EXPECT_EQ(!frame.right.empty(), expected[i].second) << i;
  }
}

TEST_F(TinyEuroc, SwappedAndRepeatedIndexLinesGiveTheSameFrames) {
  const auto clean = open();
  std::string index = "#timestamp [ns],filename\n";
  for (const int i : {1, 0, 0, 2, 4, 3, 5, 5}) {
    const std::string stamp = std::to_string(world_.frame_time_ns(i));
    index += stamp + "," + stamp + ".png\n";
  }
  write_text(mav0() / "cam0" / "data.csv", index);
  const auto shuffled = open();
  ASSERT_EQ(shuffled->frame_count(), clean->frame_count());
  for (std::size_t i = 0; i < clean->frame_count(); ++i) {
    EXPECT_EQ(shuffled->frame_time_ns(i), clean->frame_time_ns(i));
    EXPECT_EQ(shuffled->read_frame(i).left.pixels, clean->read_frame(i).left.pixels);
  }
}

TEST_F(TinyEuroc, PairsStampsThatDifferByLessThanAQuarterInterval) {
  std::string index;
  for (int i = 0; i < 6; ++i) {
    const std::int64_t time_ns = world_.frame_time_ns(i);
    index += std::to_string(time_ns + 3'000'000) + "," + std::to_string(time_ns) + ".png\n";
  }
  write_text(mav0() / "cam1" / "data.csv", index);
  const auto sequence = open();
  ASSERT_EQ(sequence->frame_count(), 6U);
  EXPECT_TRUE(sequence->read_frame(5).complete());
  EXPECT_EQ(sequence->frame_time_ns(5), world_.frame_time_ns(5));
}

TEST_F(TinyEuroc, RefusesCamerasWithoutCommonClock) {
  replace(mav0() / "cam1" / "data.csv", "#timestamp", "#");
  std::string index = read_file(mav0() / "cam1" / "data.csv");
  std::string late;
  for (int i = 0; i < 6; ++i) {
    const std::int64_t time_ns = world_.frame_time_ns(i);
    late += std::to_string(time_ns + 3'600'000'000'000) + "," + std::to_string(time_ns) + ".png\n";
  }
  write_text(mav0() / "cam1" / "data.csv", late);
  expect_input_error([&] { open(); }, ExitCode::kData, {"no left image", "one clock"});
}

TEST_F(TinyEuroc, TakesStampsFromFileNamesWithoutIndex) {
  fs::remove(mav0() / "cam0" / "data.csv");
  fs::remove(mav0() / "cam1" / "data.csv");
  const auto sequence = open();
  EXPECT_EQ(sequence->frame_count(), 6U);
  EXPECT_EQ(sequence->frame_time_ns(5), world_.frame_time_ns(5));
}

TEST_F(TinyEuroc, ExchangesCamerasThatStandTheOtherWayRound) {
  fs::rename(mav0() / "cam0", mav0() / "camX");
  fs::rename(mav0() / "cam1", mav0() / "cam0");
  fs::rename(mav0() / "camX", mav0() / "cam1");
  const auto exchanged = open();
  expect_near(exchanged->camera().T_body_left.matrix(), world_.T_body_left().matrix(), 1e-9);
  StereoFrame frame = exchanged->read_frame(0);
  const cv::Mat left(240, 320, CV_8U, frame.left.pixels.data());
  EXPECT_LT(cv::norm(left, world_.left(0), cv::NORM_L1) / (320 * 240), 6.0);
}

TEST_F(TinyEuroc, CallsImpossibleCalibrationsByFileAndLine) {
  const fs::path yaml = mav0() / "cam1" / "sensor.yaml";
  const std::string good = read_file(yaml);
  const auto refuse = [&](const std::string& text, const std::string& word) {
    write_text(yaml, text);
    expect_input_error([&] { open(); }, ExitCode::kCalibration, {"cam1/sensor.yaml", word});
  };
  const lie::SE3d T_body_right = world_.T_body_left() * world_.T_left_right();
  refuse(euroc_camera_yaml(world_, T_body_right.inverse()), "");  // inverted
  refuse(euroc_camera_yaml(world_, world_.T_body_left()), "0 m apart");
  TinyWorld other = world_;
  other.f = 0.0;
  refuse(euroc_camera_yaml(other, T_body_right), "focal length 0");
  std::string text = good;
  refuse(text.replace(text.find("[320, 240]"), 10, "[640, 480]"), "640x480");
  fs::remove(yaml);
  expect_input_error([&] { open(); }, ExitCode::kCalibration, {"cam1/sensor.yaml"});
}

TEST_F(TinyEuroc, RefusesImagesOfAnotherSizeThanCalibrated) {
  TinyWorld other = world_;
  other.width = 400;
  other.height = 300;
  write_text(mav0() / "cam0" / "sensor.yaml", euroc_camera_yaml(other, other.T_body_left()));
  write_text(mav0() / "cam1" / "sensor.yaml",
             euroc_camera_yaml(other, other.T_body_left() * other.T_left_right()));
  expect_input_error([&] { open(); }, ExitCode::kCalibration,
                     {"cam0/sensor.yaml", "400x300", "320x240"});
}

TEST_F(TinyEuroc, RefusesNamesThatLeadOutOfTheFolder) {
  write_text(mav0() / "cam0" / "data.csv", "5,../../secret.png\n");
  expect_input_error([&] { open(); }, ExitCode::kData, {"data.csv:1", "out of its folder"});
}

TEST_F(TinyEuroc, ReadsTumViWithItsKalibrFile) {
  const StereoCamera camera = world_.camera();
  const std::string intrinsics = imslam::testing::format_line(
      "  camera_model: pinhole\n  distortion_model: equidistant\n"
      "  distortion_coeffs: [0.0, 0.0, 0.0, 0.0]\n  intrinsics: [%g, %g, %g, %g]\n"
      "  resolution: [%d, %d]\n",
      camera.fx, camera.fy, camera.cx, camera.cy, camera.width, camera.height);
  write_text(dir_.path() / "dso" / "camchain.yaml",
             "cam0:\n  T_cam_imu: [" + matrix_text(world_.T_body_left().inverse().matrix()) +
                 "]\n" + intrinsics + "cam1:\n  T_cn_cnm1: [" +
                 matrix_text(world_.T_left_right().inverse().matrix()) + "]\n" + intrinsics);
  write_text(dir_.path() / "dso" / "imu_config.yaml", "gyroscope_noise_density: 0.00016\n");
  for (const char* sensor : {"cam0", "cam1", "imu0"}) fs::remove(mav0() / sensor / "sensor.yaml");
  fs::rename(mav0() / "state_groundtruth_estimate0", mav0() / "mocap0");
  const auto sequence = open();
  EXPECT_EQ(sequence->format(), "tumvi");
  EXPECT_NEAR(sequence->camera().baseline_m, world_.baseline_m, 1e-12);
  expect_near(sequence->camera().T_body_left.matrix(), world_.T_body_left().matrix(), 1e-6);
  EXPECT_EQ(sequence->imu()->noise.gyro_noise_density, 0.00016);
  EXPECT_EQ(sequence->truth()->size(), 6U);
  EXPECT_TRUE(sequence->read_frame(3).complete());
  EXPECT_NEAR(open_sequence(mav0() / "")->camera().baseline_m, world_.baseline_m, 1e-12);
}

TEST(FrameInterval, OfMicrosecondsOrBareNumbersIsRefused) {
  for (const double frames_per_second : {20e3, 1e9}) {  // 50000, 1 between two stamps
    const TempDir dir;
    TinyWorld world = small_world();
    world.start_ns = 0;
    world.frame_rate = frames_per_second;
    write_tiny_euroc(dir.path(), world);
    expect_input_error([&] { open_sequence(dir.path()); }, ExitCode::kData,
                       {"the stamps of frames advance by", "another unit"});
  }
}

TEST(FrameInterval, OfAFastCameraIsFine) {
  const TempDir dir;
  TinyWorld world = small_world();
  world.frame_rate = 1000.0;
  write_tiny_euroc(dir.path(), world);
  EXPECT_EQ(open_sequence(dir.path())->frame_count(), 6U);
}

TEST(EurocExcerpt, IsReadCompletely) {
  const fs::path folder = imslam::testing::test_data() / "euroc_mh01_excerpt";
  IMSLAM_NEEDS(folder);
  const auto sequence = open_sequence(folder);
  EXPECT_EQ(sequence->frame_count(), 220U);
  EXPECT_EQ(sequence->imu()->samples.size(), 2399U);
  EXPECT_EQ(sequence->imu()->dropped, 0U);
  const StereoCamera& camera = sequence->camera();
  // The figures that OpenCV's stereoRectify gives for EuRoC everywhere.
  EXPECT_NEAR(camera.fx, 436.235, 0.01);
  EXPECT_NEAR(camera.cx, 364.441, 0.01);
  EXPECT_NEAR(camera.cy, 256.952, 0.01);
  EXPECT_NEAR(camera.baseline_m, 0.110078, 1e-5);
  EXPECT_TRUE(sequence->read_frame(219).complete());
}

}  // namespace
}  // namespace imslam::datasets
