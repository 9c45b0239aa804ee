#include "datasets/plain.hpp"

#include <gtest/gtest.h>
#include <sys/stat.h>

#include "datasets/frame_reader.hpp"
#include "datasets/image_index.hpp"
#include "datasets/open_sequence.hpp"
#include "slam/base/file.hpp"
#include "tests/datasets/expect_error.hpp"
#include "tests/support/numeric_jacobian.hpp"
#include "tests/support/temp_dir.hpp"
#include "tests/support/tiny_dataset.hpp"

namespace imslam::datasets {
namespace {

namespace fs = std::filesystem;
using imslam::testing::expect_input_error;
using imslam::testing::expect_near;
using imslam::testing::format_line;
using imslam::testing::matrix_text;
using imslam::testing::TempDir;
using imslam::testing::TinyWorld;
using imslam::testing::write_image;
using imslam::testing::write_text;

TinyWorld small_world() {
  TinyWorld world;
  world.frames = 5;
  return world;
}

std::string own_camera(const TinyWorld& world, const lie::SE3d& T_body_camera) {
  return format_line("  size: [%d, %d]\n  intrinsics: [%g, %g, %g, %g]\n", world.width,
                     world.height, world.f, world.f, 0.5 * (world.width - 1),
                     0.5 * (world.height - 1)) +
         "  distortion: none\n  T_body_camera: [" + matrix_text(T_body_camera.matrix()) + "]\n";
}

class Plain : public ::testing::Test {
 protected:
  Plain() {
    for (int i = 0; i < world_.frames; ++i) {
      const std::string name = std::to_string(world_.frame_time_ns(i)) + ".png";
      write_image(folder() / "left" / name, world_.left(i));
      write_image(folder() / "right" / name, world_.right(i));
    }
    write_text(folder() / "imu.csv", imslam::testing::imu_csv_text(world_.imu()));
    write_text(folder() / "truth.tum", "1000 0 0 0 0 0 0 1\n");
    write_text(folder() / "calib.yaml",
               "left:\n" + own_camera(world_, world_.T_body_left()) + "right:\n" +
                   own_camera(world_, world_.T_body_left() * world_.T_left_right()) +
                   "imu:\n  gyroscope_noise_density: 3e-4\n");
  }
  fs::path folder() const { return dir_.path(); }

  const TinyWorld world_ = small_world();
  const TempDir dir_;
};

TEST_F(Plain, ReadsItsOwnCalibration) {
  const auto sequence = open_sequence(folder());
  EXPECT_EQ(sequence->format(), "plain");
  ASSERT_EQ(sequence->frame_count(), 5U);
  EXPECT_EQ(sequence->frame_time_ns(4), world_.frame_time_ns(4));
  EXPECT_TRUE(sequence->read_frame(4).complete());
  expect_near(sequence->camera().T_body_left.matrix(), world_.T_body_left().matrix(), 1e-9);
  EXPECT_EQ(sequence->imu()->noise.gyro_noise_density, 3e-4);
  EXPECT_EQ(sequence->truth()->size(), 1U);
}

TEST_F(Plain, ReadsRectifiedPairsAsTheyAre) {
  write_text(folder() / "calib.yaml",
             format_line("rectified:\n  size: [320, 240]\n  intrinsics: [220, 220, 159.5, 119.5]\n"
                         "  baseline: %g\n",
                         world_.baseline_m) +
                 "  T_body_left: [" + matrix_text(world_.T_body_left().matrix()) + "]\n");
  const auto sequence = open_sequence(folder());
  EXPECT_EQ(sequence->camera().fx, 220.0);
  const StereoFrame frame = sequence->read_frame(1);
  cv::Mat left(240, 320, CV_8U, const_cast<std::uint8_t*>(frame.left.pixels.data()));
  EXPECT_EQ(cv::norm(left, world_.left(1), cv::NORM_INF), 0.0);
}

TEST_F(Plain, AcceptsKalibrAndAppliesItsTimeShift) {
  const std::string camera = format_line(
      "  camera_model: pinhole\n  distortion_model: radtan\n  distortion_coeffs: [0, 0, 0, 0]\n"
      "  intrinsics: [%g, %g, 159.5, 119.5]\n  resolution: [320, 240]\n",
      world_.f, world_.f);
  write_text(folder() / "camchain-imucam.yaml",
             "cam0:\n  T_cam_imu: [" + matrix_text(world_.T_body_left().inverse().matrix()) +
                 "]\n  timeshift_cam_imu: 0.004\n" + camera + "cam1:\n  T_cn_cnm1: [" +
                 matrix_text(world_.T_left_right().inverse().matrix()) + "]\n" + camera);
  write_text(folder() / "imu.yaml", "gyroscope_noise_density: 7e-4\n");
  const auto sequence = open_sequence(folder());
  expect_near(sequence->camera().T_body_left.matrix(), world_.T_body_left().matrix(), 1e-9);
  EXPECT_EQ(sequence->imu()->noise.gyro_noise_density, 7e-4);
  EXPECT_EQ(sequence->imu()->samples[0].time_ns, world_.imu()[0].time_ns - 4'000'000);
}

TEST_F(Plain, TakesStampsFromTimesWhereImagesAreNumbered) {
  for (const char* side : {"left", "right"}) {
    for (int i = 0; i < world_.frames; ++i) {
      fs::rename(
          folder() / side / (std::to_string(world_.frame_time_ns(i)) + ".png"),
          folder() / side / (std::to_string(2 * i + 8) + ".png"));  // 8, 10, 12: not sorted as text
    }
  }
  write_text(folder() / "times.txt", "1000.00\n1000.05\n1000.10\n1000.15\n1000.20\n");
  const auto sequence = open_sequence(folder());
  ASSERT_EQ(sequence->frame_count(), 5U);
  EXPECT_EQ(sequence->frame_time_ns(1), world_.frame_time_ns(1));
  const StereoFrame frame = sequence->read_frame(1);
  cv::Mat left(240, 320, CV_8U, const_cast<std::uint8_t*>(frame.left.pixels.data()));
  EXPECT_LT(cv::norm(left, world_.left(1), cv::NORM_L1) / (320 * 240), 6.0);
}

TEST_F(Plain, SaysWhatIsMissing) {
  fs::rename(folder() / "calib.yaml", folder() / "other.yaml");
  expect_input_error([&] { open_sequence(folder()); }, ExitCode::kCalibration,
                     {"calib.yaml", "missing"});
  write_text(folder() / "calib.yaml",
             "rectified:\n  size: [320, 240]\n  intrinsics: [220, 220, 159.5, 119.5]\n"
             "  baseline: 0.12\n");
  expect_input_error([&] { open_sequence(folder()); }, ExitCode::kCalibration, {"T_body_left"});
  fs::remove(folder() / "imu.csv");
  EXPECT_FALSE(open_sequence(folder())->imu());
  write_text(folder() / "calib.yaml",
             "rectified:\n  size: [320, 240]\n  intrinsics: [220, 220, 159.5, 119.5]\n"
             "  baseline: -0.12\n");
  expect_input_error([&] { open_sequence(folder()); }, ExitCode::kCalibration,
                     {"calib.yaml:4", "baseline"});
}

TEST_F(Plain, OpensWithoutATruthThatHasAFlaw) {
  const std::string pose = "1000 0 0 0 0 0 0 1\n";
  for (const std::string& text : {pose + "1000.05 0 nan 0 0 0 0 1\n", pose + "1000.05 0 0",
                                  std::string("# time_s tx ty tz qx qy qz qw\n")}) {
    write_text(folder() / "truth.tum", text);
    const auto sequence = open_sequence(folder());
    EXPECT_EQ(sequence->frame_count(), 5U);
    EXPECT_FALSE(sequence->truth()) << text;
  }
}

TEST_F(Plain, DoesNotWaitForATruthThatIsAPipe) {
  fs::remove(folder() / "truth.tum");
  ASSERT_EQ(::mkfifo((folder() / "truth.tum").c_str(), 0600), 0);
  EXPECT_FALSE(open_sequence(folder())->truth());
}

TEST(ListStampedImages, GivesOneImageForEachStamp) {
  const TempDir dir;
  for (const char* name : {"5.png", "5.jpg", "7.png"}) dir.write(name, "");
  const auto images = list_stamped_images(dir.path());
  ASSERT_EQ(images.size(), 2U);
  EXPECT_EQ(images[0].time_ns, 5);
  EXPECT_EQ(images[1].time_ns, 7);
}

TEST(OpenSequence, SaysWhatItLookedFor) {
  const TempDir dir;
  expect_input_error([&] { open_sequence(dir.path()); }, ExitCode::kData,
                     {"mav0/cam0/data.csv", "image_0/", "left/"});
  expect_input_error([&] { open_sequence(dir.path() / "none"); }, ExitCode::kData,
                     {"no such folder"});
  expect_input_error([&] { open_sequence(dir.write("file.txt", "x")); }, ExitCode::kData,
                     {"is a file"});
  expect_input_error([&] { open_sequence(dir.path(), "eurock"); }, ExitCode::kUsage,
                     {"unknown dataset format", "did you mean euroc?"});
}

TEST(OpenSequence, RefusesLinksInACircleAndPipes) {
  const TempDir dir;
  fs::create_directories(dir.path() / "a");
  fs::create_symlink(dir.path() / "a" / "mav0", dir.path() / "a" / "mav0");
  expect_input_error([&] { open_sequence(dir.path() / "a"); }, ExitCode::kData, {"mav0"});
  fs::create_directories(dir.path() / "b" / "left");
  fs::create_directories(dir.path() / "b" / "right");
  ASSERT_EQ(::mkfifo((dir.path() / "b" / "calib.yaml").c_str(), 0600), 0);
  expect_input_error([&] { open_sequence(dir.path() / "b"); }, ExitCode::kCalibration,
                     {"calib.yaml", "not a regular file"});
}

TEST(OpenSequence, TakesFolderNamesWithBlanksUmlautsAndNewlines) {
  const TempDir dir;
  TinyWorld world = small_world();
  world.frames = 2;
  const fs::path folder = dir.path() / "a b\n\xC3\xA4";
  imslam::testing::write_tiny_euroc(folder, world);
  EXPECT_TRUE(open_sequence(folder)->read_frame(1).complete());
}

TEST_F(Plain, FrameReaderDeliversEveryFrameInOrder) {
  const auto sequence = open_sequence(folder());
  const auto other = open_sequence(folder());  // one thread at a time may read a sequence
  FrameReader reader(*sequence, 1, 5, 2);
  for (std::size_t i = 1; i < 5; ++i) {
    const auto frame = reader.next();
    ASSERT_TRUE(frame);
    EXPECT_EQ(frame->index, i);
    EXPECT_EQ(frame->left.pixels, other->read_frame(i).left.pixels);
  }
  EXPECT_FALSE(reader.next());
  EXPECT_FALSE(reader.next());
}

TEST_F(Plain, FrameReaderStopsWhenNobodyReads) {
  const auto sequence = open_sequence(folder());
  for (int i = 0; i < 20; ++i) FrameReader(*sequence, 0, 5, 1).next();
}

/// Fails at the third frame.
class FailingSequence final : public Sequence {
 public:
  std::string format() const override { return "failing"; }
  std::string name() const override { return "failing"; }
  const fs::path& root() const override { return root_; }
  const StereoCamera& camera() const override { return camera_; }
  std::size_t frame_count() const override { return 5; }
  std::int64_t frame_time_ns(std::size_t index) const override {
    return static_cast<std::int64_t>(index);
  }
  StereoFrame read_frame(std::size_t index) override {
    if (index == 2) throw InputError("disk gone");
    StereoFrame frame;
    frame.index = index;
    return frame;
  }
  const std::optional<ImuData>& imu() const override { return imu_; }
  const std::optional<PosePath>& truth() const override { return truth_; }
  const lie::SE3d& T_body_truth() const override { return T_; }
  std::vector<fs::path> input_files() const override { return {}; }

 private:
  fs::path root_;
  StereoCamera camera_;
  std::optional<ImuData> imu_;
  std::optional<PosePath> truth_;
  lie::SE3d T_;
};

TEST(FrameReader, PassesOnWhatTheDecodingThreadThrew) {
  FailingSequence sequence;
  FrameReader reader(sequence, 0, 5);
  EXPECT_EQ(reader.next()->index, 0U);
  EXPECT_EQ(reader.next()->index, 1U);
  EXPECT_THROW(reader.next(), InputError);
  EXPECT_THROW(reader.next(), InputError);
  EXPECT_THROW(FrameReader(sequence, 3, 6), ContractError);
}

}  // namespace
}  // namespace imslam::datasets
