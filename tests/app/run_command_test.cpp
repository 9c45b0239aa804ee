// `imslam run` and its surroundings: options, repetition, odd input.
#include <gtest/gtest.h>

#include <chrono>

#include "tests/support/chaos.hpp"
#include "tests/support/run_check.hpp"

namespace imslam {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;
using testing::Chaos;
using testing::quoted;
using testing::reproducible;
using testing::run_checked;
using testing::run_imslam;
using testing::TempDir;

constexpr const char* kShort = "--frames 0:30";

class RunCommand : public ::testing::Test {
 protected:
  std::string out() const { return " --out " + quoted((dir_.path() / "run").string()); }
  testing::CommandResult run(const std::string& dataset, const std::string& arguments = "") {
    return run_imslam(dir_, "run " + quoted(dataset) + " " + arguments + out());
  }
  testing::CommandResult run_base(const std::string& arguments) {
    return run(base_.string(), arguments);
  }
  /// Bad input must be told within five seconds (M16), and leave no result.
  void expect_refused(const std::string& dataset, int code, const std::string& reason) {
    const auto start = std::chrono::steady_clock::now();
    const auto result = run(dataset);
    const std::chrono::duration<double> taken = std::chrono::steady_clock::now() - start;
    EXPECT_EQ(result.exit_code, code) << result.err;
    EXPECT_NE(result.err.find(reason), std::string::npos) << result.err;
    EXPECT_LT(taken.count(), 5.0);
    EXPECT_FALSE(fs::exists(dir_.path() / "run" / "trajectory.tum"));
  }

  TempDir dir_;
  fs::path base_ = testing::simulated_base().sequence;
};

TEST_F(RunCommand, FramesTakesAPartAndRefusesNonsense) {
  const auto part = run_checked(dir_, base_, "--frames 10:40", "part");
  EXPECT_EQ(part.metrics.at("frames"), 30);
  for (const char* frames : {"5", "a:b", "-3:5", "5:5", "9:5", "0:0", "0:1000000", "1:2:3",
                             "99999999999999999999:", "18446744073709551615:"}) {
    EXPECT_EQ(run_base(std::string("--frames=") + frames).exit_code, 2) << frames;
    EXPECT_FALSE(fs::exists(dir_.path() / "run")) << frames;
  }
}

TEST_F(RunCommand, SeedsAreWholeNumbersFromZero) {
  for (const char* seed : {"-1", "1.5", "x"}) {
    EXPECT_EQ(run_base(std::string("--seed=") + seed).exit_code, 2) << seed;
  }
}

TEST_F(RunCommand, ItsConfigurationIsOneThatCanBeChecked) {
  ASSERT_EQ(run_base(kShort).exit_code, 0);
  const auto result = run_imslam(
      dir_, "config validate --config " + quoted((dir_.path() / "run/config.yaml").string()));
  EXPECT_EQ(result.exit_code, 0) << result.err;
}

TEST_F(RunCommand, NoReportIsWrittenIntoAFolderOfSomethingElse) {
  dir_.write("mine/notes.txt", "precious");
  EXPECT_EQ(run_imslam(dir_, "report " + quoted((dir_.path() / "mine").string())).exit_code, 3);
  EXPECT_FALSE(fs::exists(dir_.path() / "mine" / "report.html"));
}

TEST_F(RunCommand, JsonPrintsMetricsAndNothingElse) {
  const auto result = run_base(std::string(kShort) + " --json");
  ASSERT_EQ(result.exit_code, 0) << result.err;
  EXPECT_EQ(json::parse(result.out), json::parse(testing::slurp(dir_.path() / "run/metrics.json")));
}

TEST_F(RunCommand, QuietSaysNothingOnStderr) {
  const auto result = run_base(std::string(kShort) + " --quiet");
  EXPECT_EQ(result.exit_code, 0);
  EXPECT_EQ(result.err, "");
}

TEST_F(RunCommand, MetricsHoldWhatTheirReadersNeed) {
  const json& metrics = testing::clean_run().metrics;
  for (const char* key : {"frames", "coverage", "frames_per_second", "peak_memory_mb"}) {
    EXPECT_TRUE(metrics.at(key).is_number()) << key;
  }
  for (const char* part : {"vo", "graph"}) {
    for (const char* key : {"ate_se3_rmse_m", "ate_posyaw_rmse_m", "rpe_1m_rmse_m",
                            "rpe_frame_rmse_m", "rpe_frame_rmse_deg", "end_error_percent"}) {
      EXPECT_TRUE(metrics.at(part).at(key).is_number()) << part << " " << key;
    }
    EXPECT_TRUE(metrics.at(part).at("t_rel_percent").is_null());  // the path is too short
    EXPECT_TRUE(metrics.at(part).at("r_rel_deg_per_100m").is_null());
  }
}

TEST_F(RunCommand, FiguresOfAStandstillAreUndefinedNotHuge) {
  const auto result = run_base("--frames 0:6 --json");
  ASSERT_EQ(result.exit_code, 0) << result.err;
  const json metrics = json::parse(result.out);
  for (const char* part : {"vo", "graph"}) {
    EXPECT_TRUE(metrics.at(part).at("end_error_percent").is_null()) << metrics.at(part);
    EXPECT_TRUE(metrics.at(part).at("ate_se3_rmse_m").is_null()) << metrics.at(part);
  }
}

TEST_F(RunCommand, TheReportLoadsNothingFromANetwork) {  // S4
  const std::string page = testing::slurp(testing::simulated_base().clean_run / "report.html");
  EXPECT_NE(page.find("Content-Security-Policy"), std::string::npos);
  for (const char* load : {"src=\"http", "src='http", "href=\"http", "url(http", "@import",
                           "src=\"//", "fetch(", "XMLHttpRequest", "WebSocket("}) {
    EXPECT_EQ(page.find(load), std::string::npos) << load;
  }
}

TEST_F(RunCommand, ANameWithMarkupIsEscapedInTheReport) {  // S4
  const fs::path odd = dir_.path() / "<script>alert(1)<";
  fs::create_directory_symlink(fs::absolute(base_), odd);
  ASSERT_EQ(run(odd.string(), kShort).exit_code, 0);
  const std::string page = testing::slurp(dir_.path() / "run" / "report.html");
  EXPECT_EQ(page.find("<script>alert(1)"), std::string::npos);
}

// Repetition -----------------------------------------------------------------------------------

TEST_F(RunCommand, RepetitionAndThreadsChangeNothing) {  // T1, T2
  const auto& clean = testing::clean_run();
  for (const char* threads : {"1", "2"}) {
    const auto again = run_checked(dir_, base_, std::string("--threads ") + threads, threads);
    EXPECT_EQ(again.trajectory, clean.trajectory) << threads;
    EXPECT_EQ(reproducible(again.metrics), reproducible(clean.metrics)) << threads;
  }
}

TEST_F(RunCommand, LocaleTimeZoneAndPlaceChangeNothing) {  // T5
  const auto first = run_checked(dir_, base_, kShort, "first");
  const auto second =
      run_imslam(dir_, "run " + quoted(fs::absolute(base_).string()) + " " + kShort + out(),
                 "cd / && LC_ALL=de_DE.UTF-8 TZ=Asia/Tokyo");
  ASSERT_EQ(second.exit_code, 0) << second.err;
  EXPECT_EQ(testing::slurp(dir_.path() / "run" / "trajectory.tum"), first.trajectory);
}

// Output ---------------------------------------------------------------------------------------

TEST_F(RunCommand, ForeignFilesAreNeverReplaced) {
  const auto mine = dir_.write("run/mine.txt", "precious");
  for (const char* force : {"", " --force"}) {
    const auto result = run_base(std::string(kShort) + force);
    EXPECT_EQ(result.exit_code, 6) << result.err;
    EXPECT_EQ(testing::slurp(mine), "precious");
  }
}

TEST_F(RunCommand, AnEarlierRunIsReplacedOnlyByForce) {
  ASSERT_EQ(run_base(kShort).exit_code, 0);
  const auto refused = run_base(kShort);
  EXPECT_EQ(refused.exit_code, 6);
  EXPECT_NE(refused.err.find("--force"), std::string::npos) << refused.err;
  EXPECT_EQ(run_base(std::string(kShort) + " --force").exit_code, 0);
}

// Input ----------------------------------------------------------------------------------------

TEST_F(RunCommand, FoldersThatAreNoRecordingAreDataErrors) {  // M16
  expect_refused((dir_.path() / "nowhere").string(), 3, "nowhere");
  fs::create_directory(dir_.path() / "empty");
  expect_refused((dir_.path() / "empty").string(), 3, "empty");
  expect_refused(dir_.write("file", "text").string(), 3, "file");
  fs::create_directory_symlink("loop", dir_.path() / "loop");
  expect_refused((dir_.path() / "loop").string(), 3, "loop");
}

class OddRecording : public RunCommand {
 protected:
  std::string folder() const { return chaos_.folder().string(); }
  Chaos chaos_{base_, dir_.path() / "spoiled"};
};

TEST_F(OddRecording, OneFrameIsADataError) {  // M16
  for (const auto& csv : {chaos_.left_csv(), chaos_.right_csv()}) {
    Chaos::edit(csv, [](Chaos::Lines& lines) { lines.resize(1); });
  }
  expect_refused(folder(), 3, "two");
}

TEST_F(OddRecording, NoImageAtAllIsADataError) {
  chaos_.drop_images(Chaos::Side::kBoth, 1.0);
  expect_refused(folder(), 3, "no readable");
}

TEST_F(OddRecording, EmptyTablesAreDataErrors) {  // M16
  for (const auto& csv : {chaos_.imu_csv(), chaos_.left_csv()}) {
    Chaos::write(csv, "");
    expect_refused(folder(), 3, "data.csv");
  }
}

TEST_F(OddRecording, EndlessAndForeignFilesAreDataErrors) {  // M16
  for (const auto& csv : {chaos_.imu_csv(), chaos_.left_csv()}) {
    fs::remove(csv);
    fs::create_symlink("/dev/zero", csv);
    expect_refused(folder(), 3, "data.csv");
    Chaos::write(csv, std::string(1 << 20, 'x'));
    expect_refused(folder(), 3, "data.csv");
    fs::remove(csv);
    fs::create_directory(csv);
    expect_refused(folder(), 3, "data.csv");
    fs::remove(csv);
    Chaos::write(csv, "#t\n1,2,3\n");
    expect_refused(folder(), 3, "data.csv:2");
  }
}

TEST_F(OddRecording, AFileThatCannotBeReadIsADataError) {  // M16
  for (const auto& csv : {chaos_.imu_csv(), chaos_.left_csv()}) {
    fs::remove(csv);
    fs::create_symlink("/proc/self/mem", csv);  // reading fails, even for root
    expect_refused(folder(), 3, "data.csv");
  }
}

TEST_F(OddRecording, WithoutImuItRunsOnVision) {  // M16
  fs::remove_all(chaos_.mav0() / "imu0");
  const auto run = run_checked(dir_, folder(), "--frames 0:60");
  EXPECT_FALSE(run.metrics.at("inertial").get<bool>());
}

TEST_F(OddRecording, SaysHowSureTheCalibrationIs) {
  const auto run = run_checked(dir_, folder(), kShort);
  const auto& calibration = run.metrics.at("calibration");
  for (const char* key :
       {"disparity_offset_sigma_px", "focal_error_sigma", "time_offset_sigma_s"}) {
    ASSERT_TRUE(calibration.at(key).is_number()) << key;
    EXPECT_GT(calibration.at(key).get<double>(), 0.0) << key;
  }
  EXPECT_LT(calibration.at("focal_error_sigma").get<double>(), 0.02);  // less than the prior's
  const std::string& table = run.command.out;
  const auto line = table.find("Focal length, error [%]");
  ASSERT_NE(line, std::string::npos) << table;
  EXPECT_LT(table.find(" +- ", line), table.find('\n', line)) << table;
}

TEST_F(OddRecording, WithoutTruthThereAreNoErrorsToReport) {  // M16
  fs::remove_all(chaos_.mav0() / "state_groundtruth_estimate0");
  const auto run = run_checked(dir_, folder(), kShort);
  EXPECT_FALSE(run.metrics.contains("graph"));
  EXPECT_FALSE(fs::exists(dir_.path() / "run" / "truth.tum"));
}

TEST_F(OddRecording, TruthOfAnotherTimeIsAWarningOnly) {
  chaos_.move_stamps(chaos_.mav0() / "state_groundtruth_estimate0" / "data.csv", -1e9,
                     86'400'000'000'000);
  const auto run = run_checked(dir_, folder(), kShort);
  EXPECT_FALSE(run.metrics.at("warnings").empty());
}

TEST_F(OddRecording, PathsMayHoldSpacesQuotesAndUmlauts) {  // M16
  const fs::path odd = dir_.path() / "Größe 'x' \"y\" 東京\n;$(false)";
  fs::rename(chaos_.folder(), odd);
  const auto run = run_checked(dir_, odd, kShort, "Ergebnis für 東京");
  EXPECT_EQ(run.metrics.at("frames"), 30);
}

TEST_F(OddRecording, BytesThatAreNotUtf8InPathsAreNoReasonToStop) {
  const fs::path odd = dir_.path() / "caf\xe9";
  fs::rename(chaos_.folder(), odd);
  EXPECT_EQ(run(odd.string(), kShort).exit_code, 0);
}

}  // namespace
}  // namespace imslam
