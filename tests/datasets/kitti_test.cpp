#include <gtest/gtest.h>

#include "datasets/kitti_map.hpp"
#include "datasets/open_sequence.hpp"
#include "datasets/oxts.hpp"
#include "datasets/stamp_file.hpp"
#include "slam/base/file.hpp"
#include "tests/datasets/expect_error.hpp"
#include "tests/support/numeric_jacobian.hpp"
#include "tests/support/temp_dir.hpp"
#include "tests/support/test_data.hpp"
#include "tests/support/tiny_dataset.hpp"

namespace imslam::datasets {
namespace {

namespace fs = std::filesystem;
using imslam::testing::expect_input_error;
using imslam::testing::expect_near;
using imslam::testing::format_line;
using imslam::testing::TempDir;
using imslam::testing::TinyWorld;
using imslam::testing::write_image;
using imslam::testing::write_text;
using imslam::testing::write_tiny_kitti;

TinyWorld small_world() {
  TinyWorld world;
  world.frames = 6;
  world.frame_rate = 10.0;
  world.imu_rate = 100.0;
  return world;
}

void replace(const fs::path& file, const std::string& from, const std::string& to) {
  std::string text = read_file(file);
  const auto at = text.find(from);
  ASSERT_NE(at, std::string::npos) << from;
  write_text(file, text.replace(at, from.size(), to));
}

TEST(ParseSeconds, IsExactForDecimalsAndRefusesTheRest) {
  EXPECT_EQ(parse_seconds("1317384506.407050123"), 1317384506407050123);
  EXPECT_EQ(parse_seconds("1.038440e-01"), 103844000);
  EXPECT_EQ(parse_seconds("-0.5"), -500000000);
  EXPECT_EQ(parse_seconds("12"), 12000000000);
  EXPECT_EQ(parse_seconds("1e300"), std::nullopt);
  EXPECT_EQ(parse_seconds("nan"), std::nullopt);
  EXPECT_EQ(parse_seconds("1.0x"), std::nullopt);
  EXPECT_EQ(parse_seconds("9999999999"), std::nullopt);  // would overflow as nanoseconds
  EXPECT_EQ(parse_seconds("9999999999.05"), std::nullopt);
  EXPECT_EQ(parse_seconds("-9999999999"), std::nullopt);
  EXPECT_EQ(parse_seconds(""), std::nullopt);
}

TEST(ParseDateTime, CountsNanosecondsSince1970) {
  EXPECT_EQ(parse_date_time("1970-01-01 00:00:00"), 0);
  EXPECT_EQ(parse_date_time("2011-10-03 12:55:34.997992704"), 1317646534997992704);
  EXPECT_EQ(parse_date_time("2000-02-29 00:00:01.5"), 951782401500000000);
  for (const std::string text : {"2011-13-03 12:55:34", "2011-10-03", "2011-10-03 25:00:00",
                                 "2011-10-03 12:55:34.9x", "x", "-1-1-1 1:1:1", ""}) {
    EXPECT_EQ(parse_date_time(text), std::nullopt) << text;
  }
}

class TinyKitti : public ::testing::Test {
 protected:
  TinyKitti() : sequence_(write_tiny_kitti(dir_.path(), world_)) {}
  std::unique_ptr<Sequence> open() const { return open_sequence(sequence_); }

  const TinyWorld world_ = small_world();
  const TempDir dir_;
  const fs::path sequence_;
};

TEST_F(TinyKitti, OpensFromTheSequenceAndFromARootWithOneSequence) {
  for (const fs::path& folder : {sequence_, dir_.path(), sequence_ / "", sequence_ / "."}) {
    const auto sequence = open_sequence(folder);
    EXPECT_EQ(sequence->format(), "kitti_odometry");
    EXPECT_EQ(sequence->name(), "00");
    EXPECT_EQ(sequence->frame_count(), 6U);
    EXPECT_TRUE(sequence->truth()) << folder;
  }
}

TEST_F(TinyKitti, FindsTheTruthBesideTheFolderThatALinkLeadsTo) {
  fs::create_directory_symlink(sequence_, dir_.path() / "drive");
  const auto sequence = open_sequence(dir_.path() / "drive");
  ASSERT_TRUE(sequence->truth());
  EXPECT_EQ(sequence->truth()->size(), 6U);
}

TEST_F(TinyKitti, RefusesTimesInMilliseconds) {
  write_text(sequence_ / "times.txt", "0\n100\n200\n300\n400\n500\n");
  expect_input_error([&] { open(); }, ExitCode::kData, {"advance by 100 s", "another unit"});
}

TEST_F(TinyKitti, RefusesToChooseAmongSeveralSequences) {
  write_tiny_kitti(dir_.path(), world_, "04");
  expect_input_error([&] { open_sequence(dir_.path()); }, ExitCode::kData,
                     {"several sequences", "sequences/00", "sequences/04"});
}

TEST_F(TinyKitti, ReadsCamerasImuAndTruth) {
  const auto sequence = open();
  const StereoCamera& camera = sequence->camera();
  EXPECT_EQ(camera.width, 320);
  EXPECT_EQ(camera.height, 240);
  EXPECT_NEAR(camera.baseline_m, world_.baseline_m, 1e-12);
  expect_near(camera.T_body_left.matrix(), world_.T_body_left().matrix(), 1e-12);
  EXPECT_EQ(sequence->frame_time_ns(3), 300000000);
  EXPECT_EQ(sequence->imu()->samples.size(), world_.imu().size());
  ASSERT_TRUE(sequence->truth());
  EXPECT_EQ(sequence->truth()->frame, "left");
  EXPECT_NEAR(sequence->truth()->stamps_s[5], 0.5, 1e-12);
  // T_world_body = truth * T_truth_body
  const lie::SE3d T_truth_body = sequence->T_body_truth().inverse();
  const lie::SE3d motion = lie::SE3d::from_matrix(sequence->truth()->poses[0]).inverse() *
                           lie::SE3d::from_matrix(sequence->truth()->poses[5]);
  expect_near((T_truth_body.inverse() * motion * T_truth_body).matrix(),
              (world_.T_world_body(0).inverse() * world_.T_world_body(0.5)).matrix(), 1e-9);
  const StereoFrame frame = sequence->read_frame(2);
  cv::Mat left(240, 320, CV_8U, const_cast<std::uint8_t*>(frame.left.pixels.data()));
  EXPECT_EQ(cv::norm(left, world_.left(2), cv::NORM_INF), 0.0);
}

TEST_F(TinyKitti, TakesTheColourPairAndMovesItsCameraIfGreyIsMissing) {
  fs::rename(sequence_ / "image_0", sequence_ / "image_2");
  fs::rename(sequence_ / "image_1", sequence_ / "image_3");
  const double f = world_.f;
  const auto line = [&](const char* name, double x) {
    return format_line("%s: %.17g 0 159.5 %.17g 0 %.17g 119.5 0 0 0 1 0\n", name, f, f * x, f);
  };
  // Camera 2 stands 0.06 m to the left of camera 0: t = +0.06.
  write_text(sequence_ / "calib.txt", line("P2", 0.06) + line("P3", 0.06 - 0.12));
  fs::remove(sequence_ / "imu.csv");
  const auto sequence = open();
  EXPECT_NEAR(sequence->camera().baseline_m, 0.12, 1e-12);
  EXPECT_FALSE(sequence->imu());
  // Body is camera 2; the truth is of camera 0, which is 0.06 m to its right.
  EXPECT_NEAR(sequence->T_body_truth().translation().x(), 0.06, 1e-12);
}

TEST_F(TinyKitti, KeepsThePlaceOfMissingImages) {
  fs::remove(sequence_ / "image_0" / "000002.png");
  fs::remove(sequence_ / "image_1" / "000004.png");
  const auto sequence = open();
  ASSERT_EQ(sequence->frame_count(), 6U);
  EXPECT_TRUE(sequence->read_frame(2).left.empty());
  EXPECT_FALSE(sequence->read_frame(2).right.empty());
  EXPECT_TRUE(sequence->read_frame(4).right.empty());
  EXPECT_TRUE(sequence->read_frame(5).complete());
}

TEST_F(TinyKitti, NamesFileAndLineOfWhatIsWrong) {
  const auto refuse = [&](const std::string& file, const std::string& from, const std::string& to,
                          ExitCode code, const std::vector<std::string>& words) {
    const std::string good = read_file(sequence_ / file);
    replace(sequence_ / file, from, to);
    expect_input_error([&] { open(); }, code, words);
    write_text(sequence_ / file, good);
  };
  const auto kCalibration = ExitCode::kCalibration;
  refuse("calib.txt", "P1:", "Q1:", kCalibration, {"calib.txt", "'P1: ...'"});
  refuse("calib.txt", "P0: 220", "P0:", kCalibration, {"calib.txt:1", "12 numbers", "found 11"});
  refuse("calib.txt", "P0: 220", "P0: -220", kCalibration, {"calib.txt:1", "fx, fy > 0"});
  refuse("calib.txt", "P1: 220", "P1: 221", kCalibration, {"calib.txt:2", "different intrinsics"});
  refuse("calib.txt", "159.5 -26.", "159.5 26.", kCalibration, {"calib.txt:2", "exchanged"});
  refuse("T_cam0_imu.txt", "1", "2", kCalibration, {"T_cam0_imu.txt:1", "no rotation"});
  refuse("T_cam0_imu.txt", " 1\n", "\n", kCalibration, {"T_cam0_imu.txt:1", "found 15"});
  refuse("times.txt", "2.000000e-01", "abc", ExitCode::kData, {"times.txt:3", "seconds"});
  refuse("times.txt", "4.000000e-01", "0.1", ExitCode::kData, {"times.txt:5", "0.200 s before"});
  fs::remove(sequence_ / "T_cam0_imu.txt");
  expect_input_error([&] { open(); }, kCalibration, {"T_cam0_imu.txt", "cannot be opened"});
}

TEST_F(TinyKitti, LeavesOutATruthOfAnotherLength) {
  write_text(dir_.path() / "poses" / "00.txt", "1 0 0 0 0 1 0 0 0 0 1 0\n");
  EXPECT_FALSE(open()->truth());
}

TEST(KittiMap, KnowsTheFramesOfSequence08AndThat03IsNotPublished) {
  const auto drive = drive_of_sequence("08");
  ASSERT_TRUE(drive);
  EXPECT_EQ(drive->name(), "2011_09_30_drive_0028");
  EXPECT_EQ(drive->first, 1100U);
  EXPECT_EQ(drive->last, 5170U);
  expect_input_error([] { drive_of_sequence("03"); }, ExitCode::kData,
                     {"03", "2011_09_26_drive_0067", "not published"});
  EXPECT_FALSE(drive_of_sequence("11"));
}

constexpr std::int64_t kRawStart = 1317384506000000000;  // 2011-09-30 12:08:26

std::string date_time(std::int64_t time_ns) {
  const std::int64_t since_ns = time_ns - kRawStart;
  return format_line(
      "2011-09-30 12:%02d:%02d.%09d\n", 8 + static_cast<int>((26 + since_ns / 1000000000) / 60),
      static_cast<int>((26 + since_ns / 1000000000) % 60), static_cast<int>(since_ns % 1000000000));
}

/// The packet of the tiny world at t; the map is flat enough within a few metres.
std::string oxts_packet(const TinyWorld& world, double t) {
  constexpr double kRadius = 6378137.0;
  constexpr double kDegrees = 180.0 / M_PI;
  const lie::SE3d T = world.T_world_body(t);
  const Eigen::Vector3d p = T.translation();
  const Eigen::Matrix3d R = T.rotation().matrix();
  const double yaw = std::atan2(R(1, 0), R(0, 0));
  const double pitch = std::asin(-R(2, 0));
  const double roll = std::atan2(R(2, 1), R(2, 2));
  const ImuSample s = world.imu_sample(t);
  const auto& a = s.linear_acceleration;
  const auto& w = s.angular_velocity;
  return format_line("%.15g %.15g %.9g %.15g %.15g %.15g 0 0 0 0 0 ", kDegrees * p.y() / kRadius,
                     kDegrees * p.x() / kRadius, 100.0 + p.z(), roll, pitch, yaw) +
         format_line("%.15g %.15g %.15g 0 0 0 %.15g %.15g %.15g 0 0 0 0.1 0.1 4 8 5 5 5\n", a.x(),
                     a.y(), a.z(), w.x(), w.y(), w.z());
}

/// Stamps of the drive's images long after its packets.
void move_images_away(const fs::path& sync, const TinyWorld& world) {
  std::string stamps;
  for (int i = 0; i < world.frames; ++i) {
    stamps += date_time(kRawStart + to_nanoseconds(1200.0 + i / world.frame_rate));
  }
  write_text(sync / "image_00" / "timestamps.txt", stamps);
}

/// A raw drive of the tiny world with `frames` images; unsorted packets and an empty stamp line.
void write_tiny_raw(const fs::path& root,
                    const TinyWorld& world,
                    const std::string& drive,
                    int first_real = 0) {
  const fs::path date = root / "2011_09_30";
  const fs::path sync = date / (drive + "_sync");
  const fs::path extract = date / (drive + "_extract");
  std::string stamps;
  for (int i = 0; i < world.frames + first_real; ++i) {
    stamps += date_time(kRawStart + to_nanoseconds(0.5 + i / world.frame_rate));
    if (i < first_real) continue;
    const std::string name = format_line("%010d.png", i);
    write_image(sync / "image_00" / "data" / name, world.left(i - first_real));
    write_image(sync / "image_01" / "data" / name, world.right(i - first_real));
  }
  write_text(sync / "image_00" / "timestamps.txt", stamps);
  write_text(sync / "image_01" / "timestamps.txt", stamps);
  const double offset_s = 0.5 + first_real / world.frame_rate;
  std::string packets;
  const int count = static_cast<int>((world.frames / world.frame_rate + 0.4) * 100);
  for (int i = 0; i < count; ++i) {
    const int k = i % 7 == 3 ? i + 1 : (i % 7 == 4 ? i - 1 : i);  // neighbours out of order
    const double t = k / 100.0 - 0.2;
    packets += i == 10 ? "\n" : date_time(kRawStart + to_nanoseconds(offset_s + t));
    write_text(extract / "oxts" / "data" / format_line("%010d.txt", i), oxts_packet(world, t));
  }
  write_text(extract / "oxts" / "timestamps.txt", packets);
  const std::string P = "%s: %.17g 0 159.5 %.17g 0 %.17g 119.5 0 0 0 1 0\n";
  const double f = world.f;
  write_text(date / "calib_cam_to_cam.txt",
             "calib_time: 09-Jan-2012 13:57:47\nS_rect_00: 320 240\n"
             "R_rect_00: 1 0 0 0 1 0 0 0 1\n" +
                 format_line(P.c_str(), "P_rect_00", f, 0.0, f) +
                 format_line(P.c_str(), "P_rect_01", f, -f * world.baseline_m, f));
  const lie::SE3d T_cam_velo = world.T_body_left().inverse();
  const auto& t = T_cam_velo.translation();
  write_text(date / "calib_velo_to_cam.txt",
             format_line("R: 0 -1 0 0 0 -1 1 0 0\nT: %.17g %.17g %.17g\n", t.x(), t.y(), t.z()));
  write_text(date / "calib_imu_to_velo.txt", "R: 1 0 0 0 1 0 0 0 1\nT: 0 0 0\n");
}

TEST(KittiRaw, ReadsADriveWithUnsortedPacketsAndAnEmptyStamp) {
  const TempDir dir;
  const TinyWorld world = small_world();
  write_tiny_raw(dir.path(), world, "2011_09_30_drive_0016");
  const auto sequence = open_sequence(dir.path() / "2011_09_30" / "2011_09_30_drive_0016_sync");
  EXPECT_EQ(sequence->format(), "kitti_raw");
  ASSERT_EQ(sequence->frame_count(), 6U);
  EXPECT_EQ(sequence->frame_time_ns(2), kRawStart + 700000000);
  EXPECT_TRUE(sequence->read_frame(5).complete());
  expect_near(sequence->camera().T_body_left.matrix(), world.T_body_left().matrix(), 1e-9);
  ASSERT_TRUE(sequence->imu());
  EXPECT_EQ(sequence->imu()->samples.size(), 99U);  // 100 packets, one without stamp
  const ImuSample& sample = sequence->imu()->samples[50];
  const double t = to_seconds(sample.time_ns - kRawStart) - 0.5;
  expect_near(sample.angular_velocity, world.imu_sample(t).angular_velocity, 1e-9);
  ASSERT_TRUE(sequence->truth());
  ASSERT_EQ(sequence->truth()->size(), 6U);
  const Eigen::Matrix4d moved = sequence->truth()->poses[0].inverse() * sequence->truth()->poses[5];
  expect_near(moved, (world.T_world_body(0).inverse() * world.T_world_body(0.5)).matrix(), 1e-4);
}

TEST(KittiRaw, OpensTheFramesOfAnOdometrySequenceByItsNumber) {
  const TempDir dir;
  const TinyWorld world = small_world();
  write_tiny_raw(dir.path(), world, "2011_09_30_drive_0028", 1100);
  const auto sequence = open_sequence(dir.path() / "08" / "");
  EXPECT_EQ(sequence->name(), "08");
  ASSERT_EQ(sequence->frame_count(), 6U);
  EXPECT_EQ(sequence->frame_time_ns(0), kRawStart + to_nanoseconds(0.5 + 110.0));
  EXPECT_TRUE(sequence->read_frame(0).complete());
  expect_input_error([&] { open_sequence(dir.path() / "03"); }, ExitCode::kData,
                     {"03", "not published"});
  expect_input_error([&] { open_sequence(dir.path() / "00"); }, ExitCode::kData,
                     {"2011_10_03_drive_0027_sync", "not here"});
}

TEST(KittiRaw, PacketsOfAnotherTimeThanTheImagesAreNoImu) {
  const TempDir dir;
  const TinyWorld world = small_world();
  const fs::path folder = write_tiny_kitti(dir.path() / "dataset", world, "04");
  fs::remove(folder / "imu.csv");
  const fs::path raw = dir.path() / "dataset" / "raw";
  write_tiny_raw(raw, world, "2011_09_30_drive_0016");
  EXPECT_TRUE(open_sequence(folder)->imu());
  const fs::path sync = raw / "2011_09_30" / "2011_09_30_drive_0016_sync";
  move_images_away(sync, world);
  EXPECT_FALSE(open_sequence(sync)->imu());
  EXPECT_FALSE(open_sequence(folder)->imu());
}

TEST(KittiRaw, SuppliesTheImuOfAnOdometrySequence) {
  const TempDir dir;
  const TinyWorld world = small_world();
  const fs::path folder = write_tiny_kitti(dir.path() / "dataset", world, "04");
  fs::remove(folder / "imu.csv");
  EXPECT_FALSE(open_sequence(folder)->imu());
  write_tiny_raw(dir.path() / "dataset" / "raw", world, "2011_09_30_drive_0016");
  replace(folder / "calib.txt", "Tr: 0 -1 0 0 0 0 -1 0 1 0 0 0",
          format_line("Tr: 0 -1 0 %.17g 0 0 -1 %.17g 1 0 0 %.17g",
                      world.T_body_left().inverse().translation().x(),
                      world.T_body_left().inverse().translation().y(),
                      world.T_body_left().inverse().translation().z()));
  const auto sequence = open_sequence(folder);
  ASSERT_TRUE(sequence->imu());
  expect_near(sequence->camera().T_body_left.matrix(), world.T_body_left().matrix(), 1e-9);
  const ImuSample& sample = sequence->imu()->samples[40];  // on the clock of times.txt
  expect_near(sample.angular_velocity,
              world.imu_sample(to_seconds(sample.time_ns)).angular_velocity, 1e-9);
}

TEST(KittiExcerpt, IsReadCompletely) {
  const fs::path folder = imslam::testing::test_data() / "kitti_00_excerpt";
  IMSLAM_NEEDS(folder);
  const auto sequence = open_sequence(folder);
  EXPECT_EQ(sequence->frame_count(), 80U);
  EXPECT_EQ(sequence->camera().width, 1241);
  EXPECT_NEAR(sequence->camera().baseline_m, 0.53717, 1e-4);
  EXPECT_EQ(sequence->truth()->size(), 80U);
  EXPECT_EQ(sequence->imu()->dropped, 0U);
  EXPECT_TRUE(sequence->read_frame(79).complete());
  // The IMU looks forward along x, the camera along z.
  const Eigen::Vector3d forward =
      sequence->camera().T_body_left.rotation() * Eigen::Vector3d::UnitZ();
  EXPECT_GT(forward.x(), 0.99);
}

}  // namespace
}  // namespace imslam::datasets
