#include <gtest/gtest.h>

#include <cmath>
#include <nlohmann/json.hpp>
#include <string>

#include "tests/support/command.hpp"
#include "tests/support/test_data.hpp"

namespace imslam {
namespace {

using nlohmann::json;
using testing::quoted;
using testing::run_imslam;
using testing::TempDir;

bool contains(const std::string& text, const std::string& part) {
  return text.find(part) != std::string::npos;
}

/// A climbing figure of eight in TUM format; `error` [m] swings sideways.
std::string tum_text(double error, double stamp_scale = 1.0, double shift_s = 0.0) {
  std::string text = "# time_s tx ty tz qx qy qz qw\n";
  for (int i = 0; i < 300; ++i) {
    const double s = 0.05 * i;
    char line[200];
    std::snprintf(line, sizeof(line), "%.9f %.9f %.9f %.9f 0 0 %.12f %.12f\n",
                  (1000.0 + s + shift_s) * stamp_scale, 4.0 * std::sin(0.5 * s),
                  2.0 * std::sin(s) + error * std::sin(7.0 * i), 0.1 * s, std::sin(0.15 * s),
                  std::cos(0.15 * s));
    text += line;
  }
  return text;
}

class EvalCommand : public ::testing::Test {
 protected:
  testing::CommandResult eval(const std::string& arguments = "") {
    return run_imslam(dir_, "eval " + quoted(reference_.string()) + " " +
                                quoted(estimate_.string()) + " " + arguments);
  }

  TempDir dir_;
  std::filesystem::path reference_ = dir_.write("truth.tum", tum_text(0.0));
  std::filesystem::path estimate_ = dir_.write("my estimate.tum", tum_text(0.01));
};

TEST_F(EvalCommand, PrintsEverythingInOneTable) {
  const auto result = eval();
  EXPECT_EQ(result.exit_code, 0) << result.err;
  for (const char* part :
       {"sha256", "matched", "coverage 100.0 %", "SE(3) aligned", "yaw and translation aligned",
        "Sim(3) aligned, scale", "1 m, all pairs", "KITTI", "10..50 % of the path", "at the end"}) {
    EXPECT_TRUE(contains(result.out, part)) << part << "\n" << result.out;
  }
  EXPECT_FALSE(contains(result.out, "nan"));
  EXPECT_TRUE(result.err.empty()) << result.err;
}

TEST_F(EvalCommand, JsonIsOneObjectWithPairsAndStats) {
  const auto result = eval("--metric ape --align se3 --json");
  ASSERT_EQ(result.exit_code, 0) << result.err;
  const json object = json::parse(result.out);
  EXPECT_EQ(object.at("pairs"), 300);
  EXPECT_EQ(object.at("stats").size(), 7U);
  const double rmse = object.at("stats").at("rmse");
  EXPECT_GT(rmse, 0.005);
  EXPECT_LT(rmse, 0.01);
}

TEST_F(EvalCommand, RpeTakesDeltaUnitAndAllPairs) {
  const auto frames = json::parse(eval("--metric rpe --delta 10 --json").out);
  EXPECT_EQ(frames.at("pairs"), 29);
  const auto all = json::parse(eval("--metric rpe --delta 10 --all-pairs --json").out);
  EXPECT_EQ(all.at("pairs"), 290);
  const auto metres = eval("--metric rpe --delta 1 --unit meters --relation rotation_angle_deg");
  EXPECT_TRUE(contains(metres.out,
                       "RPE w.r.t. rotation angle in degrees (deg)\n"
                       "for delta = 1.0 (m) using consecutive pairs\n(not aligned)\n\n"
                       "       max\t0.000000\n"))
      << metres.out;
}

TEST_F(EvalCommand, JsonWithoutMetricHasTheKeysOfARun) {
  const json object = json::parse(eval("--json").out);
  for (const char* key : {"ate_se3_rmse_m", "ate_posyaw_rmse_m", "rpe_1m_rmse_m",
                          "rpe_frame_rmse_m", "rpe_frame_rmse_deg", "end_error_percent"}) {
    EXPECT_TRUE(object.at(key).is_number()) << key;
  }
  EXPECT_TRUE(object.at("t_rel_percent").is_null());  // the path is too short
  EXPECT_EQ(object.at("reference").at("sha256").get<std::string>().size(), 64U);
}

TEST_F(EvalCommand, WritesCsvLatexAndZipAndNeverOverwritesUnasked) {
  const auto file = [&](const char* name) { return quoted((dir_.path() / name).string()); };
  const std::string arguments = "--metric ape --csv " + file("t.csv") + " --latex " +
                                file("t.tex") + " --save-zip " + file("r.zip");
  ASSERT_EQ(eval(arguments).exit_code, 0);
  EXPECT_TRUE(contains(testing::slurp(dir_.path() / "t.csv"), "metric,condition,unit,pairs,rmse"));
  EXPECT_TRUE(contains(testing::slurp(dir_.path() / "t.tex"), "\\begin{tabular}"));
  EXPECT_EQ(testing::slurp(dir_.path() / "r.zip").substr(0, 2), "PK");
  const auto again = eval(arguments);
  EXPECT_EQ(again.exit_code, 6);
  EXPECT_TRUE(contains(again.err, "exists already"));
  EXPECT_EQ(eval(arguments + " --force").exit_code, 0);
}

TEST_F(EvalCommand, ATableWithANameThatIsTooLongIsAnOutputError) {
  const auto result = eval("--csv " + quoted((dir_.path() / std::string(300, 'x')).string()));
  EXPECT_EQ(result.exit_code, 6) << result.err;
}

TEST_F(EvalCommand, APipeIsReadOnceAndHasNoSha256) {
  const auto result =
      run_imslam(dir_, "eval /dev/fd/3 " + quoted(estimate_.string()) + " --metric ape --json 3<&0",
                 "cat " + quoted(reference_.string()) + " |");
  ASSERT_EQ(result.exit_code, 0) << result.err;
  const json object = json::parse(result.out);
  EXPECT_EQ(object.at("pairs"), 300);
  EXPECT_TRUE(object.at("reference").at("sha256").is_null());
  EXPECT_EQ(object.at("estimate").at("sha256").get<std::string>().size(), 64U);
}

TEST_F(EvalCommand, TakesNamesThatAreNotUtf8) {
  estimate_ = dir_.write("caf\xE9.tum", tum_text(0.01));
  const auto zip = dir_.path() / "r.zip";
  const auto figure = eval("--metric ape --json --save-zip " + quoted(zip.string()));
  ASSERT_EQ(figure.exit_code, 0) << figure.err;
  EXPECT_EQ(json::parse(figure.out).at("pairs"), 300);
  EXPECT_EQ(testing::slurp(zip).substr(0, 2), "PK");
  const auto all = eval("--json");
  ASSERT_EQ(all.exit_code, 0) << all.err;
  EXPECT_TRUE(json::parse(all.out).is_object());
}

TEST_F(EvalCommand, TheWholeTableGoesIntoCsvAndLatex) {
  const auto csv = dir_.path() / "t.csv";
  const auto tex = dir_.path() / "t.tex";
  ASSERT_EQ(eval("--csv " + quoted(csv.string()) + " --latex " + quoted(tex.string())).exit_code,
            0);
  EXPECT_TRUE(contains(testing::slurp(csv), "ATE,SE(3) aligned,m,300,"));
  EXPECT_TRUE(contains(testing::slurp(tex), "ATE & SE(3) aligned & m & "));
  EXPECT_TRUE(contains(testing::slurp(tex), "\\bottomrule"));
}

TEST_F(EvalCommand, CarriesTheEstimateToAnotherFrame) {
  const std::string shifted = "--metric ape --json --T-body-eval '0 0 0.5 0 0 0 1'";
  EXPECT_NEAR(json::parse(eval(shifted).out).at("stats").at("mean").get<double>(), 0.5, 1e-3);
  const auto file = dir_.write("T.txt", "1 0 0 0\n0 1 0 0\n0 0 1 0.5\n0 0 0 1\n");
  const auto same = eval("--metric ape --json --T-body-eval " + quoted(file.string()));
  EXPECT_NEAR(json::parse(same.out).at("stats").at("mean").get<double>(), 0.5, 1e-3);
  EXPECT_EQ(eval("--T-body-eval '1 2 3'").exit_code, 2);
  EXPECT_EQ(eval("--T-body-eval '1 2 3 0 0 0 0'").exit_code, 2);
}

TEST_F(EvalCommand, ProjectsIntoAPlane) {
  const std::string lifted = "--metric ape --json --T-body-eval '0 0 0.5 0 0 0 1' --project xy";
  EXPECT_LT(json::parse(eval(lifted).out).at("stats").at("max").get<double>(), 0.02);
}

TEST_F(EvalCommand, BadCommandLinesAreUsageErrors) {
  for (const char* arguments :
       {"--metric foo", "--metric ape --align foo", "--metric rpe --delta 0",
        "--metric rpe --delta 1.5", "--metric ape --relation point_distance_error_ratio",
        "--t-max-diff -1", "--save-zip x.zip"}) {
    EXPECT_EQ(eval(arguments).exit_code, 2) << arguments;
  }
}

TEST_F(EvalCommand, AMissingFileIsADataError) {
  EXPECT_EQ(run_imslam(dir_, "eval /nowhere/a.tum " + quoted(estimate_.string())).exit_code, 3);
}

// M17: exit 8, the reason on stderr, nothing that looks like a figure on stdout.
TEST_F(EvalCommand, WhatCannotBeEvaluatedEndsWithCodeEightAndTheReason) {
  struct Case {
    std::string text;
    const char* reason;
  };
  std::string line;
  for (int i = 0; i < 20; ++i) {
    line += std::to_string(1000.0 + 0.05 * i) + " " + std::to_string(0.5 * i) + " 0 0 0 0 0 1\n";
  }
  std::string still;
  for (int i = 0; i < 20; ++i) still += std::to_string(1000.0 + 0.05 * i) + " 1 2 3 0 0 0 1\n";
  const Case cases[] = {
      {tum_text(0.0) + "1100 nan 0 0 0 0 0 1\n", "is not a pose"},
      {tum_text(0.0) + "1100 1 0 0 0 0 0 0\n", "the quaternion is zero"},
      {"1000.0 0 0 0 0 0 0 1\n1000.05 1 0 0 0 0 0 1\n", "Degenerate covariance rank"},
      {line, "Degenerate covariance rank"},
      {still, "Degenerate covariance rank"},
      {tum_text(0.0, 1.0, 5000.0), "do not overlap"},
      {tum_text(0.0, 1e9), "nanoseconds"},
  };
  for (const Case& bad : cases) {
    estimate_ = dir_.write("bad.tum", bad.text);
    const auto result = eval("--metric ape --align se3 --json");
    EXPECT_EQ(result.exit_code, 8) << bad.reason << "\n" << result.out << result.err;
    EXPECT_TRUE(contains(result.err, bad.reason)) << bad.reason << "\n" << result.err;
    EXPECT_TRUE(result.out.empty()) << result.out;
    const auto all = eval();
    EXPECT_EQ(all.exit_code, 8) << bad.reason;
    EXPECT_FALSE(contains(all.out, "nan")) << all.out;
  }
}

TEST_F(EvalCommand, KittiDriftOfAShortPathIsNullAndCodeEight) {
  const auto result = eval("--metric kitti --json");
  EXPECT_EQ(result.exit_code, 8);
  const json object = json::parse(result.out);
  EXPECT_TRUE(object.at("t_rel_percent").is_null());
  EXPECT_EQ(object.at("segments"), 0);
}

TEST_F(EvalCommand, SuggestsTheBoundThatWouldMatch) {
  estimate_ = dir_.write("late.tum", tum_text(0.01, 1.0, 0.02));
  const auto result = eval("--metric ape");
  EXPECT_EQ(result.exit_code, 8);
  EXPECT_TRUE(contains(result.err, "--t-max-diff 0.02")) << result.err;
}

TEST_F(EvalCommand, AgreesWithEvoOnItsFixtures) {
  const auto folder = testing::test_fixtures() / "evo";
  IMSLAM_NEEDS(folder / "expected.json");
  const json expected = json::parse(testing::slurp(folder / "expected.json"));
  int cases = 0;
  for (const json& wanted : expected.at("results")) {  // every 20th: each starts the program
    if (wanted.contains("error") || cases++ % 20 != 0) continue;
    const std::string ending = wanted.at("set").get<std::string>()[0] == 'k' ? ".kitti" : ".tum";
    reference_ = folder / (wanted.at("set").get<std::string>() + "_ref" + ending);
    estimate_ = folder / (wanted.at("set").get<std::string>() + "_est" + ending);
    std::string arguments = "--json --metric ";
    if (wanted.at("metric") == "kitti_odometry") {
      const auto actual = json::parse(eval(arguments + "kitti").out);
      EXPECT_NEAR(actual.at("t_rel_percent").get<double>(),
                  wanted.at("t_rel_percent").get<double>(), 1e-9);
      continue;
    }
    const auto align = wanted.at("align").get<std::string>();
    arguments += wanted.at("metric").get<std::string>() + " --relation " +
                 wanted.at("relation").get<std::string>() + " --align " +
                 (align == "se3_n100" ? "se3 --align-first 100" : align);
    if (wanted.at("metric") == "rpe") {
      arguments += " --unit " + wanted.at("unit").get<std::string>() + " --delta " +
                   wanted.at("delta").dump();
      if (wanted.at("all_pairs").get<bool>()) arguments += " --all-pairs";
      if (wanted.at("pairs_from_reference").get<bool>()) arguments += " --pairs-from-reference";
    }
    const auto actual = json::parse(eval(arguments).out);
    EXPECT_EQ(actual.at("pairs"), wanted.at("n")) << arguments;
    const double rmse = wanted.at("stats").at("rmse");
    EXPECT_NEAR(actual.at("stats").at("rmse").get<double>(), rmse, 1e-9 * rmse + 1e-15) << wanted;
  }
}

}  // namespace
}  // namespace imslam
