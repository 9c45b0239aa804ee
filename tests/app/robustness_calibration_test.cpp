// Wrong calibrations and units through the executable; ../shared/reference/reliability.md, M10-M15.
#include <gtest/gtest.h>

#include "tests/support/chaos.hpp"
#include "tests/support/run_check.hpp"

namespace imslam {
namespace {

using testing::Chaos;
using testing::quoted;
using testing::run_imslam;
using testing::TempDir;

class WrongCalibration : public ::testing::Test {
 protected:
  testing::CommandResult run() {
    return run_imslam(dir_, "run " + quoted(chaos_.folder().string()) + " --out " +
                                quoted((dir_.path() / "run").string()));
  }
  testing::CommandResult check(const std::string& arguments = "") {
    return run_imslam(dir_, "check " + quoted(chaos_.folder().string()) + " " + arguments);
  }
  /// The output folder must not look like a result.
  void expect_refused(const std::string& reason, int code = 4) {
    const auto result = run();
    EXPECT_EQ(result.exit_code, code) << result.err;
    EXPECT_NE(result.err.find(reason), std::string::npos) << result.err;
    EXPECT_FALSE(std::filesystem::exists(dir_.path() / "run" / "trajectory.tum"));
  }
  /// Both check and run must say what is wrong.
  void expect_warned(const std::string& reason) {
    const auto checked = check("--strict");
    EXPECT_EQ(checked.exit_code, 10) << checked.out;
    EXPECT_NE(checked.out.find(reason), std::string::npos) << checked.out;
    const auto spoiled = run();
    EXPECT_NE(spoiled.err.find(reason), std::string::npos) << spoiled.exit_code << spoiled.err;
    std::filesystem::remove_all(dir_.path() / "run");
  }
  void scale_focal_length(double factor) {
    for (const int camera : {0, 1}) {
      Chaos::replace_between(
          chaos_.sensor_file(camera), "intrinsics: [", "]", [&](const std::string& text) {
            const auto cells = split(text, ',');
            std::string scaled;
            for (std::size_t i = 0; i < 4; ++i) {
              const double value = std::stod(std::string(cells.at(i)));
              scaled += (i == 0 ? "" : ", ") + std::to_string(i < 2 ? factor * value : value);
            }
            return scaled;
          });
    }
  }
  void set_intrinsics(const std::string& text) {
    Chaos::replace_between(chaos_.sensor_file(0), "intrinsics: [", "]",
                           [&](const std::string&) { return text; });
  }

  TempDir dir_;
  Chaos chaos_{testing::simulated_base().sequence, dir_.path() / "spoiled"};
};

TEST_F(WrongCalibration, NothingIsFoundInTheUnspoiledSequence) {
  const auto result = check("--strict");
  EXPECT_EQ(result.exit_code, 0) << result.out << result.err;
}

TEST_F(WrongCalibration, ExchangedImagesAreRefused) {  // M10
  chaos_.exchange_images();
  expect_refused("exchanged");
  EXPECT_EQ(check().exit_code, 4);
}

TEST_F(WrongCalibration, InvertedExtrinsicsAreFoundByCheck) {  // M11
  chaos_.invert_extrinsics(0);
  chaos_.invert_extrinsics(1);
  const auto result = check();
  EXPECT_EQ(result.exit_code, 4) << result.out;
  EXPECT_NE(result.out.find("invert"), std::string::npos) << result.out;
}

TEST_F(WrongCalibration, AMatrixThatIsNoRotationIsRefused) {  // M11
  chaos_.edit_extrinsics(0, [](std::array<double, 16>& T) { T[1] += 0.01; });
  expect_refused("sensor.yaml");
}

TEST_F(WrongCalibration, AMirrorIsRefused) {  // M11
  chaos_.edit_extrinsics(1, [](std::array<double, 16>& T) {
    for (const std::size_t i : {0U, 4U, 8U}) T.at(i) = -T.at(i);
  });
  expect_refused("sensor.yaml");
}

TEST_F(WrongCalibration, CamerasAtOnePlaceAreRefused) {  // M11
  std::array<double, 16> left = {};
  chaos_.edit_extrinsics(0, [&](std::array<double, 16>& T) { left = T; });
  chaos_.edit_extrinsics(1, [&](std::array<double, 16>& T) { T = left; });
  expect_refused("0 m apart");
}

TEST_F(WrongCalibration, FocalLengthsThatCannotBeAreRefused) {  // M11
  for (const char* text : {"0, 229, 183, 124", "-229, 229, 183, 124", ".nan, 229, 183, 124",
                           "1e300, 229, 183, 124", "229, 229"}) {
    set_intrinsics(text);
    expect_refused("sensor.yaml");
  }
}

TEST_F(WrongCalibration, ImagesOfAnotherSizeAreRefused) {  // M11
  Chaos::replace_between(chaos_.sensor_file(0), "resolution: [", "]",
                         [](const std::string&) { return "752, 480"; });
  expect_refused("376x240");
}

TEST_F(WrongCalibration, AFocalLengthOffByATwentiethIsSurvived) {  // M11
  for (const double factor : {0.95, 1.05}) {
    scale_focal_length(factor);
    const auto run = testing::run_checked(dir_, chaos_.folder(), "", std::to_string(factor));
    EXPECT_LE(run.ate_m(), 0.05 * run.metrics.at("path_length_m").get<double>());
    scale_focal_length(1.0 / factor);
  }
}

TEST_F(WrongCalibration, AFocalLengthOffByAFifthIsSaidByCheckAndRun) {  // M11
  for (const double factor : {0.8, 1.2}) {
    scale_focal_length(factor);
    expect_warned("focal length");
    scale_focal_length(1.0 / factor);
  }
}

TEST_F(WrongCalibration, ABaselineOffByAFactorOfTwoIsSaidByCheckAndRun) {  // M11
  for (const double factor : {0.5, 2.0}) {
    chaos_.scale_baseline(factor);
    expect_warned("baseline");
    chaos_.scale_baseline(1.0 / factor);
  }
}

TEST_F(WrongCalibration, ANegativeBaselineIsRefused) {  // M11
  chaos_.scale_baseline(-1.0);
  expect_refused("exchanged");
}

TEST_F(WrongCalibration, InvertedExtrinsicsAreSaidByRun) {  // M11
  chaos_.invert_extrinsics(0);
  chaos_.invert_extrinsics(1);
  const auto result = run();
  EXPECT_NE(result.err.find("invert"), std::string::npos) << result.exit_code << result.err;
}

TEST_F(WrongCalibration, DistortionInAnotherOrderIsFoundByCheck) {  // M11
  for (const int camera : {0, 1}) {                                 // p1 p2 k1 k2
    Chaos::replace_between(chaos_.sensor_file(camera), "distortion_coefficients: [", "]",
                           [](const std::string& text) {
                             const auto cells = split(text, ',');
                             return std::string(cells.at(2)) + "," + std::string(cells.at(3)) +
                                    "," + std::string(cells.at(0)) + "," + std::string(cells.at(1));
                           });
  }
  EXPECT_NE(check("--strict").exit_code, 0);
}

TEST_F(WrongCalibration, AccelerationInUnitsOfGravityIsFoundByCheck) {  // M15
  chaos_.scale_imu(1.0, 1.0 / 9.81);
  const auto result = check();
  EXPECT_EQ(result.exit_code, 3) << result.out;
  EXPECT_NE(result.out.find("in g"), std::string::npos) << result.out;
}

TEST_F(WrongCalibration, RatesInDegreesAreFoundByCheck) {  // M15
  chaos_.scale_imu(57.29577951308232, 1.0);
  const auto result = check();
  EXPECT_EQ(result.exit_code, 3) << result.out;
  EXPECT_NE(result.out.find("deg"), std::string::npos) << result.out;
}

TEST_F(WrongCalibration, AccelerationWithoutGravityIsFoundByCheck) {  // M15
  chaos_.scale_imu(1.0, 1e-3);
  const auto result = check();
  EXPECT_EQ(result.exit_code, 3) << result.out;
  EXPECT_NE(result.out.find("gravity is missing"), std::string::npos) << result.out;
}

TEST_F(WrongCalibration, AClockThatLeapsIsFoundByCheck) {  // M9
  chaos_.move_stamps(chaos_.imu_csv(), 3.0, 3'600'000'000'000);
  EXPECT_NE(check("--strict").exit_code, 0);
}

}  // namespace
}  // namespace imslam
