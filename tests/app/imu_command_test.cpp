#include <fmt/format.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <nlohmann/json.hpp>
#include <string>

#include "tests/support/command.hpp"

namespace imslam {
namespace {

using testing::quoted;
using testing::run_imslam;
using testing::TempDir;

constexpr double kTurn = 0.5;    // [rad/s] about z
constexpr double kRadius = 2.0;  // [m]

/// A ride on a merry-go-round, x ahead: 12 s at 100 Hz.
void write_log(const TempDir& dir, const std::string& name) {
  std::string imu = "#timestamp [ns],w,a\n";
  std::string truth = "# time_s tx ty tz qx qy qz qw\n";
  for (int i = 0; i <= 1200; ++i) {
    const double angle = kTurn * 0.01 * i;
    imu += fmt::format("{},0,0,{},0,{},9.81\n", i * std::int64_t{10'000'000}, kTurn,
                       kTurn * kTurn * kRadius);
    truth += fmt::format("{:.3f} {} {} 0 0 0 {} {}\n", 0.01 * i, kRadius * std::sin(angle),
                         -kRadius * std::cos(angle), std::sin(angle / 2.0), std::cos(angle / 2.0));
  }
  dir.write(name + "_imu.csv", imu);
  dir.write(name + "_truth.tum", truth);
}

class ImuCommand : public ::testing::Test {
 protected:
  testing::CommandResult imu(const std::string& arguments) {
    return run_imslam(dir_, "imu " + quoted((dir_.path() / "ride").string()) + " " + arguments);
  }

  void SetUp() override { write_log(dir_, "ride"); }

  TempDir dir_;
};

TEST_F(ImuCommand, PrintsATablePerLogAndOneOfAll) {
  const auto other = quoted((dir_.path() / "other").string());
  write_log(dir_, "other");
  const auto result = imu(other + " --windows 1,5");
  EXPECT_EQ(result.exit_code, 0) << result.err;
  for (const char* part : {"ride\n", "other\n", "all logs\n", "raw ", "rest bias ", "graph bias ",
                           "1201 readings", "never at rest: as raw", "inside"}) {
    EXPECT_NE(result.out.find(part), std::string::npos) << part << "\n" << result.out;
  }
  EXPECT_EQ(result.out.find("nan"), std::string::npos) << result.out;
}

TEST_F(ImuCommand, WritesTheTableAsCsvAndJson) {
  const auto out = dir_.path() / "out";
  const std::string arguments = "--windows 1,5 --out " + quoted(out.string());
  EXPECT_EQ(imu(arguments).exit_code, 0);
  const std::string csv = testing::slurp(out / "imu.csv");
  EXPECT_EQ(csv.rfind("log,method,window_s,windows,degraded,rotation_rms_deg", 0), 0U) << csv;
  EXPECT_EQ(std::count(csv.begin(), csv.end(), '\n'), 1 + 4 * 2);
  const auto json = nlohmann::json::parse(testing::slurp(out / "imu.json"));
  ASSERT_EQ(json.size(), 1U);
  EXPECT_EQ(json[0]["log"], "ride");
  ASSERT_EQ(json[0]["rows"].size(), 8U);
  EXPECT_EQ(json[0]["rows"][0]["method"], "raw");
  EXPECT_EQ(json[0]["rows"][0]["windows"], 12);
  EXPECT_LT(json[0]["rows"][0]["position_rms_m"], 1e-3);
  EXPECT_EQ(imu(arguments).exit_code, 6);  // not overwritten
  EXPECT_EQ(imu(arguments + " --force").exit_code, 0);
}

TEST_F(ImuCommand, SaysWhatIsWrong) {
  EXPECT_EQ(imu("--windows 1,x").exit_code, 2);
  EXPECT_EQ(imu("--windows 0").exit_code, 2);
  const auto too_long = imu("--windows 100");
  EXPECT_EQ(too_long.exit_code, 8);
  EXPECT_NE(too_long.err.find("shorter --windows"), std::string::npos) << too_long.err;
  EXPECT_EQ(run_imslam(dir_, "imu").exit_code, 2);
  const auto none = run_imslam(dir_, "imu " + quoted((dir_.path() / "none").string()));
  EXPECT_EQ(none.exit_code, 3);
  EXPECT_NE(none.err.find("none_imu.csv"), std::string::npos) << none.err;
  EXPECT_EQ(imu("--weights w.safetensors").exit_code, 5);
}

}  // namespace
}  // namespace imslam
