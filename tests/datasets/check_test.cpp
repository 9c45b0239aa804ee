#include "datasets/check.hpp"

#include <gtest/gtest.h>

#include <algorithm>

#include "datasets/open_sequence.hpp"
#include "datasets/rotation_comparison.hpp"
#include "slam/base/file.hpp"
#include "tests/datasets/expect_error.hpp"
#include "tests/support/temp_dir.hpp"
#include "tests/support/test_data.hpp"
#include "tests/support/tiny_dataset.hpp"

namespace imslam::datasets {
namespace {

namespace fs = std::filesystem;
using imslam::testing::expect_input_error;
using imslam::testing::imu_csv_text;
using imslam::testing::matrix_text;
using imslam::testing::TempDir;
using imslam::testing::TinyWorld;
using imslam::testing::write_text;
using imslam::testing::write_tiny_kitti;

std::string text_of(const std::vector<Finding>& findings) {
  std::string text;
  for (const Finding& finding : findings) text += to_text(finding) + "\n";
  return text;
}

std::size_t count(const std::vector<Finding>& findings, Severity severity) {
  return static_cast<std::size_t>(
      std::count_if(findings.begin(), findings.end(),
                    [severity](const Finding& f) { return f.severity == severity; }));
}

/// The first finding whose text holds `words`, or null.
const Finding* find(const std::vector<Finding>& findings, const std::string& words) {
  for (const Finding& finding : findings) {
    if (to_text(finding).find(words) != std::string::npos) return &finding;
  }
  return nullptr;
}

void expect_finding(const std::vector<Finding>& findings,
                    Severity severity,
                    const std::string& words,
                    std::size_t line = 0) {
  const Finding* finding = find(findings, words);
  ASSERT_NE(finding, nullptr) << "no \"" << words << "\" in:\n" << text_of(findings);
  EXPECT_EQ(finding->severity, severity) << to_text(*finding);
  if (line > 0) {
    EXPECT_EQ(finding->line, line) << to_text(*finding);
  }
  if (severity == Severity::kError) {
    EXPECT_NE(finding->code, ExitCode::kOk);
    EXPECT_FALSE(finding->remedy.empty()) << to_text(*finding);
  }
}

TinyWorld swaying_world() {
  TinyWorld world;
  world.frames = 50;
  world.start_ns = 0;
  return world;
}

/// One recording for all tests; each writes what it changes and the next one restores it.
class CheckTiny : public ::testing::Test {
 protected:
  CheckTiny() : sequence_(write_tiny_kitti(dir_.path(), world_)) {}

  std::vector<Finding> check() const { return check_sequence(sequence_); }
  std::vector<Finding> check_without_vision() const {
    CheckOptions options;
    options.vision_frames = 0;
    return check_sequence(sequence_, options);
  }
  void write_imu(const std::vector<ImuSample>& samples) const {
    write_text(sequence_ / "imu.csv", imu_csv_text(samples));
  }
  void replace(const std::string& file, const std::string& from, const std::string& to) const {
    std::string text = read_file(sequence_ / file);
    ASSERT_NE(text.find(from), std::string::npos) << from;
    for (auto at = text.find(from); at != std::string::npos; at = text.find(from, at + to.size())) {
      text.replace(at, from.size(), to);
    }
    write_text(sequence_ / file, text);
  }

  const TinyWorld world_ = swaying_world();
  const TempDir dir_;
  const fs::path sequence_;
};

TEST_F(CheckTiny, HasNothingToComplainOfInACleanRecording) {
  const auto findings = check();
  EXPECT_EQ(count(findings, Severity::kError), 0U) << text_of(findings);
  EXPECT_EQ(count(findings, Severity::kWarning), 0U) << text_of(findings);
  EXPECT_NE(find(findings, "50 stereo frames in 2.45 s, 20.00 Hz"), nullptr) << text_of(findings);
  EXPECT_NE(find(findings, "200.0 Hz"), nullptr) << text_of(findings);
  EXPECT_NE(find(findings, "vision against gyro"), nullptr) << text_of(findings);
}

TEST_F(CheckTiny, SeesThatLeftAndRightAreExchanged) {
  EXPECT_FALSE(check_stereo_order(*open_sequence(sequence_)));
  fs::rename(sequence_ / "image_0", sequence_ / "image_x");
  fs::rename(sequence_ / "image_1", sequence_ / "image_0");
  fs::rename(sequence_ / "image_x", sequence_ / "image_1");
  const auto finding = check_stereo_order(*open_sequence(sequence_));
  ASSERT_TRUE(finding);
  EXPECT_EQ(finding->code, ExitCode::kCalibration);
  expect_finding(check(), Severity::kError, "left and right are exchanged");
}

TEST_F(CheckTiny, SeesThatTheExtrinsicsAreInverted) {
  write_text(sequence_ / "T_cam0_imu.txt", matrix_text(world_.T_body_left().matrix(), " ") + "\n");
  const auto findings = check();
  expect_finding(findings, Severity::kError, "looks inverted");
  EXPECT_EQ(find(findings, "looks inverted")->code, ExitCode::kCalibration);
}

TEST_F(CheckTiny, SeesAWrongAxisInTheExtrinsics) {
  const lie::SE3d turned(lie::SO3d::exp(Eigen::Vector3d(1.5707963267948966, 0, 0)),
                         Eigen::Vector3d::Zero());
  write_text(sequence_ / "T_cam0_imu.txt",
             matrix_text((turned * world_.T_body_left().inverse()).matrix(), " ") + "\n");
  expect_finding(check(), Severity::kError, "rotation does not fit");
}

TEST_F(CheckTiny, WarnsOfAFocalLengthThatIsOffByAFifth) {
  const std::string good = read_file(sequence_ / "calib.txt");
  for (const std::string wrong : {"176", "264"}) {
    write_text(sequence_ / "calib.txt", good);
    replace("calib.txt", " 220 ", " " + wrong + " ");
    expect_finding(check(), Severity::kWarning, "the focal length seems to be wrong");
  }
}

TEST_F(CheckTiny, FindsTheOffsetOfTheClocksWithinThreeMilliseconds) {
  const auto sequence = open_sequence(sequence_);
  VisualProbe probe(sequence->camera());
  for (std::size_t i = 0; i < sequence->frame_count(); ++i) probe.add(sequence->read_frame(i));
  for (const double offset_s : {-0.050, -0.0213, -0.003, 0.0, 0.0077, 0.035, 0.050}) {
    std::vector<ImuSample> samples = sequence->imu()->samples;
    for (ImuSample& sample : samples) {
      sample.time_ns += to_nanoseconds(offset_s);
      sample.angular_velocity += Eigen::Vector3d(0.02, -0.05, 0.03);  // a bias must not matter
    }
    const RotationComparison fit =
        compare_rotations(probe.rotations(), samples, sequence->camera().T_body_left.rotation());
    ASSERT_TRUE(fit.valid);
    EXPECT_NEAR(fit.time_offset_s, offset_s, 0.002);
    EXPECT_NEAR(fit.scale, 1.0, 0.03);
    const lie::SO3d error = sequence->camera().T_body_left.rotation() * fit.R_left_body;
    EXPECT_LT(error.log().norm(), 0.03);
  }
}

TEST_F(CheckTiny, WarnsOfClocksThatDiffer) {
  std::vector<ImuSample> samples = world_.imu();
  for (ImuSample& sample : samples) sample.time_ns += 30'000'000;
  write_imu(samples);
  const auto findings = check();
  expect_finding(findings, Severity::kWarning, "camera and IMU clocks differ by +");
}

TEST_F(CheckTiny, SeesUnitsOfGravityAndDegrees) {
  std::vector<ImuSample> samples = world_.imu();
  for (ImuSample& sample : samples) sample.linear_acceleration /= 9.80665;
  write_imu(samples);
  expect_finding(check_without_vision(), Severity::kError, "accelerometer seems to be in g");
  samples = world_.imu();
  for (ImuSample& sample : samples) sample.angular_velocity *= 57.29577951308232;
  write_imu(samples);
  expect_finding(check(), Severity::kError, "it is in degrees per second");
}

TEST_F(CheckTiny, SeesStampsInOtherUnits) {
  for (const std::int64_t divisor : {std::int64_t{1000}, std::int64_t{1000000}}) {
    std::vector<ImuSample> samples = world_.imu();
    for (ImuSample& sample : samples) sample.time_ns /= divisor;
    write_imu(samples);
    const auto findings = check_without_vision();
    expect_finding(findings, Severity::kError, "not nanoseconds");
    EXPECT_NE(find(findings, "covers"), nullptr) << text_of(findings);
  }
}

TEST_F(CheckTiny, SeesStampsOfFramesInMilliseconds) {
  std::string times;
  for (int i = 0; i < world_.frames; ++i) times += std::to_string(50 * i) + "\n";
  write_text(sequence_ / "times.txt", times);
  expect_finding(check_without_vision(), Severity::kError, "advance by 50 s");
}

TEST_F(CheckTiny, ListsAFlawOfTheTruthByFileAndLine) {
  const std::string pose = "1 0 0 0 0 1 0 0 0 0 1 0\n";
  const std::pair<std::string, std::string> cases[] = {
      {pose + "1 0 0 nan 0 1 0 0 0 0 1 0\n", "00.txt:2: column 4: nan is not a pose"},
      {pose + "1 0 0 0 0 1", "00.txt:2: expected 12 columns"},
      {"# no pose\n", "00.txt: holds no poses"}};
  for (const auto& [text, words] : cases) {
    write_text(dir_.path() / "poses" / "00.txt", text);
    const auto findings = check_without_vision();
    expect_finding(findings, Severity::kError, words);
    EXPECT_EQ(count(findings, Severity::kError), 1U) << text_of(findings);
    EXPECT_NE(find(findings, "IMU samples in"), nullptr) << text_of(findings);  // and goes on
  }
}

TEST_F(CheckTiny, ListsAnErrorOnceWhereThePathIsRelative) {
  const auto check_relative = [&] {
    CheckOptions options;
    options.vision_frames = 0;
    return check_sequence(fs::relative(sequence_), options);
  };
  fs::remove(sequence_ / "imu.csv");
  fs::create_directory(sequence_ / "imu.csv");  // about no line
  auto findings = check_relative();
  EXPECT_EQ(count(findings, Severity::kError), 1U) << text_of(findings);
  replace("times.txt", "1.000000e-01", "abc");
  findings = check_relative();
  EXPECT_EQ(count(findings, Severity::kError), 2U) << text_of(findings);
  expect_finding(findings, Severity::kError, "expected one stamp in seconds", 3);
}

TEST_F(CheckTiny, SeesTheClockJump) {
  for (const double jump_s : {3600.0, -3600.0}) {
    std::vector<ImuSample> samples = world_.imu();
    for (std::size_t i = 200; i < samples.size(); ++i) {
      samples[i].time_ns += to_nanoseconds(jump_s);
    }
    write_imu(samples);
    // One header line, then sample i on line i + 2.
    expect_finding(check_without_vision(), Severity::kError, "the clock jumps by", 202);
  }
}

TEST_F(CheckTiny, ListsWhatTheReaderWouldSortDropAndRefuse) {
  std::vector<ImuSample> samples = world_.imu();
  samples[20].angular_velocity.x() = std::nan("");
  samples.insert(samples.begin() + 31, samples[30]);
  samples.insert(samples.begin() + 51, samples[50]);
  samples[51].angular_velocity.y() += 1.0;
  std::swap(samples[80], samples[81]);
  std::string text = imu_csv_text(samples);
  write_text(sequence_ / "imu.csv", text + "12,0.1");
  auto findings = check_without_vision();
  expect_finding(findings, Severity::kWarning, "1 samples hold nan or inf", 22);
  expect_finding(findings, Severity::kWarning, "1 samples are exact copies", 33);
  expect_finding(findings, Severity::kWarning, "1 samples have the stamp of another", 53);
  expect_finding(findings, Severity::kWarning, "1 samples stand behind later ones", 83);
  expect_finding(findings, Severity::kWarning, "the last line is cut off");
  EXPECT_EQ(count(findings, Severity::kError), 0U) << text_of(findings);

  write_text(sequence_ / "imu.csv", text + "1;2;3\nabc,1,1,1,1,1,1\n1,2\n1,3\n1,4\n");
  findings = check_without_vision();
  expect_finding(findings, Severity::kError, "\"abc\"");
  expect_finding(findings, Severity::kError, "2 more lines like these");
}

TEST_F(CheckTiny, CountsGapsAndWhatTheImuDoesNotCover) {
  std::vector<ImuSample> samples = world_.imu();
  samples.erase(samples.begin() + 100, samples.begin() + 160);
  samples.resize(300);
  write_imu(samples);
  const auto findings = check_without_vision();
  expect_finding(findings, Severity::kWarning, "IMU gap of 305 ms", 101);
  expect_finding(findings, Severity::kWarning, "the IMU covers");
}

TEST_F(CheckTiny, TellsImpossibleSamplesFromSaturatedOnes) {
  std::vector<ImuSample> samples = world_.imu();
  samples[40].linear_acceleration.z() = 160.0;
  samples[70].linear_acceleration.x() = 1e30;
  samples[90].linear_acceleration.x() = 1e30;
  write_imu(samples);
  const auto findings = check_without_vision();
  expect_finding(findings, Severity::kWarning, "1 samples reach the range of the sensor", 42);
  expect_finding(findings, Severity::kWarning, "2 samples hold impossible values", 72);
  const Finding* gravity = find(findings, "norm of the mean");
  ASSERT_NE(gravity, nullptr);
  EXPECT_NE(gravity->what.find("norm of the mean 9."), std::string::npos) << gravity->what;
}

TEST_F(CheckTiny, LooksAtTheSamplesWhereTheCalibrationIsWrong) {
  write_text(sequence_ / "calib.txt", "P0: nonsense\n");
  std::vector<ImuSample> samples = world_.imu();
  samples.erase(samples.begin() + 100, samples.begin() + 160);
  write_imu(samples);
  const auto findings = check_without_vision();
  EXPECT_GE(count(findings, Severity::kError), 1U);
  expect_finding(findings, Severity::kWarning, "IMU gap of 305 ms", 101);
}

TEST_F(CheckTiny, ListsMissingAndDamagedImagesByFile) {
  fs::remove(sequence_ / "image_0" / "000007.png");
  write_text(sequence_ / "image_1" / "000008.png", "no image");
  CheckOptions options;
  options.all_images = true;
  options.vision_frames = 0;
  const auto findings = check_sequence(sequence_, options);
  expect_finding(findings, Severity::kWarning, "1 frames lack the left image");
  expect_finding(findings, Severity::kWarning, "000008.png: image neither a PNG nor a JPEG");
}

TEST_F(CheckTiny, WarnsOfUniformImages) {
  for (int i = 0; i < world_.frames; ++i) {
    const std::string name = imslam::testing::format_line("%06d.png", i);
    for (const char* side : {"image_0", "image_1"}) {
      imslam::testing::write_image(sequence_ / side / name, cv::Mat(240, 320, CV_8U, 17));
    }
  }
  const auto findings = check();
  expect_finding(findings, Severity::kWarning, "100 images are uniform");
  expect_finding(findings, Severity::kWarning, "only 0 stereo matches");
}

TEST(CheckSequence, TurnsWhateverStopsItIntoAFinding) {
  const TempDir dir;
  expect_finding(check_sequence(dir.path()), Severity::kError, "no known dataset here");
  expect_finding(check_sequence(dir.path() / "none"), Severity::kError, "no such folder");
  TinyWorld one;
  one.frames = 1;
  const fs::path sequence = write_tiny_kitti(dir.path(), one);
  expect_finding(check_sequence(sequence), Severity::kError, "1 stereo frame only");
  write_text(sequence / "calib.txt", "P0: 1\n");
  const auto findings = check_sequence(sequence);
  expect_finding(findings, Severity::kError, "calib.txt:1: expected 12 numbers", 1);
  EXPECT_EQ(find(findings, "calib.txt")->code, ExitCode::kCalibration);
}

TEST(CheckSequence, FindsLinksInACircleAndNamesThatAreTooLong) {
  const TempDir dir;
  fs::create_directory_symlink("loop", dir.path() / "loop");
  for (const std::string& name : {std::string("loop"), std::string(300, 'x')}) {
    expect_finding(check_sequence(dir.path() / name), Severity::kError, "cannot be read");
  }
}

TEST(CheckOptions, NameTheBoundThatIsBroken) {
  CheckOptions options;
  options.image_samples = 0;
  expect_input_error([&] { options.validate(); }, ExitCode::kUsage,
                     {"check.image_samples is 0", "at least 1"});
}

TEST(CheckExcerpt, FindsNoErrorInTheRealRecordings) {
  for (const std::string name : {"euroc_mh01_excerpt", "kitti_00_excerpt"}) {
    const fs::path folder = imslam::testing::test_data() / name;
    IMSLAM_NEEDS(folder);
    CheckOptions options;
    options.vision_frames = 70;
    options.image_samples = 10;
    const auto findings = check_sequence(folder, options);
    EXPECT_EQ(count(findings, Severity::kError), 0U) << text_of(findings);
    EXPECT_EQ(count(findings, Severity::kWarning), 0U) << text_of(findings);
    EXPECT_NE(find(findings, "vision against gyro over"), nullptr) << text_of(findings);
  }
}

TEST(CheckExcerpt, NamesTheGapOfTheEurocExcerpt) {
  const fs::path folder = imslam::testing::test_data() / "euroc_mh01_excerpt";
  IMSLAM_NEEDS(folder);
  CheckOptions options;
  options.vision_frames = 0;
  options.image_samples = 3;
  expect_finding(check_sequence(folder, options), Severity::kInfo,
                 "gap of 100 ms between frames 162 and 163");
}

TEST(CheckExcerpt, SeesExchangedRawImagesThatRectificationShiftsAnywhere) {
  const fs::path folder = imslam::testing::test_data() / "euroc_mh01_excerpt" / "mav0";
  IMSLAM_NEEDS(folder);
  const TempDir dir;
  for (const std::string camera : {"cam0", "cam1"}) {
    fs::create_directories(dir.path() / "mav0" / camera);
    for (const char* file : {"data.csv", "sensor.yaml"}) {
      fs::copy(folder / camera / file, dir.path() / "mav0" / camera / file);
    }
    const std::string other = camera == "cam0" ? "cam1" : "cam0";
    fs::create_directory_symlink(fs::absolute(folder) / other / "data",
                                 dir.path() / "mav0" / camera / "data");
  }
  EXPECT_TRUE(check_stereo_order(*open_sequence(dir.path())));
  EXPECT_FALSE(check_stereo_order(*open_sequence(folder)));
}

TEST(CheckExcerpt, SeesTheExchangedCamerasOfARealDrive) {
  const fs::path folder = imslam::testing::test_data() / "kitti_00_excerpt" / "sequences" / "00";
  IMSLAM_NEEDS(folder);
  const TempDir dir;
  const fs::path root = fs::absolute(folder);
  for (const char* file : {"calib.txt", "times.txt"}) fs::copy(root / file, dir.path() / file);
  fs::create_directory_symlink(root / "image_1", dir.path() / "image_0");
  fs::create_directory_symlink(root / "image_0", dir.path() / "image_1");
  EXPECT_TRUE(check_stereo_order(*open_sequence(dir.path())));
  EXPECT_FALSE(check_stereo_order(*open_sequence(root)));
}

}  // namespace
}  // namespace imslam::datasets
