// Suite files and the faces of their table.
#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

#include "slam/system/suite_bench.hpp"
#include "slam/system/suite_file.hpp"
#include "slam/system/suite_table.hpp"
#include "tests/support/temp_dir.hpp"

namespace imslam::system {
namespace {

using testing::TempDir;

constexpr const char* kSuite =
    "name: Two_50% & more\n"
    "metric: kitti\n"
    "sequences:\n"
    "  - {name: \"01\", path: sequences/01}\n"
    "  - {name: \"02\", path: [elsewhere, sequences/02]}\n"
    "sources: {P: \"a paper\"}\n"
    "published:\n"
    "  - {name: Old_1, source: P, average: {t_rel: 5.45, r_rel: 5.966}}\n"
    "  - {name: New, source: P, t_rel: [1.0, 2.0], r_rel: [0.25, \"-\"]}\n";

Suite read(const TempDir& dir, const std::string& text) {
  return read_suite(dir.write("suite.yaml", text));
}

std::string replaced(std::string text, const std::string& from, const std::string& to) {
  return text.replace(text.find(from), from.size(), to);
}

/// The suite with `from` replaced by `to` must be refused, at `line`, saying `reason`.
void expect_refused(const std::string& from,
                    const std::string& to,
                    int line,
                    const std::string& reason) {
  const TempDir dir;
  try {
    read(dir, replaced(kSuite, from, to));
    FAIL() << to;
  } catch (const InputError& error) {
    const std::string what = error.what();
    EXPECT_EQ(error.code(), ExitCode::kUsage) << what;
    EXPECT_NE(what.find("suite.yaml:" + std::to_string(line) + ":"), std::string::npos) << what;
    EXPECT_NE(what.find(reason), std::string::npos) << what;
  }
}

std::vector<SuiteRow> our_rows() {
  return {
      {"imslam, VO",
       {{{1.5, 0.5}, "", ExitCode::kOk}, {{}, "sequences/02\nis not there", ExitCode::kData}}},
      {"imslam, IMU",
       {{{1.25, 0.125}, "", ExitCode::kOk}, {{}, "sequences/02\nis not there", ExitCode::kData}}}};
}

TEST(SuiteFile, IsReadAsWritten) {
  const TempDir dir;
  const Suite suite = read(dir, kSuite);
  ASSERT_EQ(suite.sequences.size(), 2U);
  EXPECT_EQ(suite.sequences[1].paths.size(), 2U);
  ASSERT_EQ(suite.published.size(), 2U);
  EXPECT_EQ(suite.published[0].averages[1], 5.966);
  EXPECT_EQ(suite.published[1].averages[0], 1.5);  // the mean of all
  EXPECT_FALSE(suite.published[1].averages[1]);    // one is missing
}

TEST(SuiteFile, WhatIsWrongIsToldWithItsLine) {
  expect_refused("metric: kitti", "metrik: kitti", 2, "did you mean 'metric'?");
  expect_refused("metric: kitti", "metric: tum", 2, "kitti or euroc");
  expect_refused("source: P, average", "sauce: P, average", 8, "did you mean 'source'?");
  expect_refused("source: P, average", "source: Q, average", 8, "'Q'");
  expect_refused("t_rel: 5.45", "t_rell: 5.45", 8, "did you mean 't_rel'?");
  expect_refused("t_rel: 5.45", "t_rel: many", 8, "a finite number");
  expect_refused("[1.0, 2.0]", "[1.0]", 9, "one number (or -) per sequence, 2, got 1");
  expect_refused("name: \"02\"", "name: \"01\"", 5, "'01' is taken");
  expect_refused("name: \"02\"", "name: \"../02\"", 5, "names a folder");
  expect_refused("name: \"02\", path", "name: \"02\", name: b, path", 5, "twice");
  expect_refused("sources: {", "sources: {{", 6, "not valid YAML");
}

TEST(SuiteFile, WithoutSequencesIsRefused) {
  const TempDir dir;
  EXPECT_THROW(read(dir, "name: a\nmetric: euroc\nsequences: []\n"), InputError);
  EXPECT_THROW(read(dir, "name: a\nmetric: euroc\n"), InputError);
  EXPECT_THROW(read(dir, ""), InputError);
  EXPECT_THROW(read_suite(dir.path() / "nowhere.yaml"), InputError);
}

TEST(SuiteTable, TextIsAlignedAndSaysWhyThereAreDashes) {
  const TempDir dir;
  const auto table = make_suite_table(read(dir, kSuite), our_rows());
  EXPECT_EQ(as_text(table),
            "Two_50% & more\n"
            "\n"
            "t_rel [%]                01        02   average\n"
            "Old_1 [P]                 -         -     5.450\n"
            "New [P]               1.000     2.000     1.500\n"
            "-----------------------------------------------\n"
            "imslam, VO            1.500         -     1.500 *\n"
            "imslam, IMU           1.250         -     1.250 *\n"
            "\n"
            "r_rel [deg/100 m]        01        02   average\n"
            "Old_1 [P]                 -         -     5.966\n"
            "New [P]               0.250         -         -\n"
            "-----------------------------------------------\n"
            "imslam, VO            0.500         -     0.500 *\n"
            "imslam, IMU           0.125         -     0.125 *\n"
            "\n"
            "[P] a paper\n"
            "* mean of the sequences that have a figure, not of all: do not compare with the "
            "others\n"
            "02: sequences/02 is not there\n");
}

TEST(SuiteTable, LatexIsEscaped) {
  const TempDir dir;
  const std::string latex = as_latex(make_suite_table(read(dir, kSuite), our_rows()));
  EXPECT_NE(latex.find("\nOld\\_1 [P] & -- & -- & 5.450 \\\\\n"), std::string::npos) << latex;
  EXPECT_NE(latex.find("\\begin{tabular}{lrrr}\n\\toprule\n & 01 & 02 & avg. \\\\\n"),
            std::string::npos)
      << latex;
  EXPECT_NE(latex.find("imslam, VO & 1.500 & -- & 1.500$^*$ \\\\\n"), std::string::npos) << latex;
  EXPECT_NE(latex.find("\n% 02: sequences/02 is not there\n"), std::string::npos) << latex;
}

TEST(SuiteTable, CsvHoldsAllDigits) {
  const TempDir dir;
  auto rows = our_rows();
  rows[0].cells[0].figures[0] = 1.0 / 3.0;
  const std::string csv = as_csv(make_suite_table(read(dir, kSuite), rows));
  EXPECT_NE(csv.find("\"imslam, VO\",,t_rel_percent,0.3333333333333333,,0.3333333333333333,1\n"),
            std::string::npos)
      << csv;
  EXPECT_NE(csv.find("New,P,t_rel_percent,1,2,1.5,\n"), std::string::npos) << csv;
}

TEST(SuiteTable, TheExitCodeIsThatOfTheFirstSequenceThatFailed) {
  EXPECT_EQ(exit_code_of(our_rows()), ExitCode::kData);
  auto rows = our_rows();
  rows[1].cells[0].code = ExitCode::kTrackingLost;
  EXPECT_EQ(exit_code_of(rows), ExitCode::kTrackingLost);
  EXPECT_EQ(exit_code_of({}), ExitCode::kOk);
}

TEST(RunSuite, RowsAreTheSameForAnyNumberOfProcesses) {
  const TempDir dir;
  Suite suite = read(dir, kSuite);
  for (int i = 3; i < 8; ++i) suite.sequences.push_back({"s" + std::to_string(i), {"."}});
  suite.published.clear();
  const SuiteMethod method = {
      "m", [](const SuiteSequence& sequence, const auto& /*data*/) {
        if (sequence.name == "s4") throw InputError("damaged");
        return SuiteCell{{1.0 / static_cast<double>(sequence.name[1]), {}}, "seen", ExitCode::kOk};
      }};
  std::string alone;
  for (const int jobs : {1, 2, 4}) {
    ProcessOptions options;
    options.jobs = jobs;
    run_in_processes(options, [&](ProcessGroup& group) {
      const auto rows = run_suite(suite, dir.path(), {method, method}, group);
      if (group.rank() != 0) return ExitCode::kOk;
      const std::string csv = as_csv(make_suite_table(suite, rows));
      EXPECT_EQ(exit_code_of(rows), ExitCode::kData);
      if (jobs == 1) alone = csv;
      EXPECT_EQ(csv, alone) << jobs;
      return ExitCode::kOk;
    });
  }
}

TEST(SuiteCell, TakesTheFiguresOfABlock) {
  const auto metrics = nlohmann::json::parse(
      R"({"vo": {"t_rel_percent": 1.5, "r_rel_deg_per_100m": 0.25, "ate_se3_rmse_m": null}})");
  const SuiteCell cell = suite_cell(metrics, "vo", suite_figures("kitti"));
  EXPECT_EQ(cell.figures, (SuiteValues{1.5, 0.25}));
  EXPECT_EQ(cell.code, ExitCode::kOk);
  EXPECT_EQ(suite_cell(metrics, "vo", suite_figures("euroc")).code, ExitCode::kEvaluation);
  EXPECT_EQ(suite_cell(metrics, "graph", suite_figures("kitti")).code, ExitCode::kEvaluation);
}

}  // namespace
}  // namespace imslam::system
