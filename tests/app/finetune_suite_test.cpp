// `imslam finetune SUITE` through the executable, in one process and in several.
#include <gtest/gtest.h>

#include <cstdlib>

#include "slam/base/process_group.hpp"
#include "tests/support/finetune_check.hpp"

namespace imslam {
namespace {

namespace fs = std::filesystem;
using testing::finetune_metrics;
using testing::quoted;
using testing::run_imslam;
using testing::slurp;

class FinetuneSuite : public ::testing::Test {
 protected:
  FinetuneSuite() { write_suite("euroc"); }

  static std::string place(std::size_t recording) {
    const auto& base = testing::simulated_base();
    return fs::absolute(base.recordings.at(recording).sequence).lexically_normal().string();
  }

  /// Three recordings: two of the base's world, one of another.
  void write_suite(const std::string& metric) {
    dir_.write("suite.yaml", "name: Three\nmetric: " + metric + "\nroot: /\nsequences:\n" +
                                 "  - {name: first, path: " + place(0) + "}\n" +
                                 "  - {name: second, path: " + place(1) + "}\n" +
                                 "  - {name: third, path: " + place(2) + "}\n");
  }

  /// Equal arguments are equal commands wherever they are called.
  testing::CommandResult finetune(const std::string& place,
                                  const std::string& more = "",
                                  const std::string& before = "") {
    fs::create_directories(dir_.path() / place);
    return run_imslam(dir_,
                      std::string("finetune ../suite.yaml") + testing::kTinyFinetune +
                          "finetune.matcher=off --out tuned --quiet " + more,
                      "cd " + quoted((dir_.path() / place).string()) + " && " + before);
  }
  fs::path tuned(const std::string& place) const { return dir_.path() / place / "tuned"; }

  void expect_same(const std::string& a, const std::string& b) {
    testing::expect_same_files(tuned(a), tuned(b), testing::kLearnedFiles);
    testing::expect_same_files(tuned(a), tuned(b), {"adapted/third/trajectory.tum"});
    EXPECT_EQ(finetune_metrics(tuned(a)), finetune_metrics(tuned(b)));
  }

  testing::TempDir dir_;
};

TEST_F(FinetuneSuite, LearnsFromAllSequencesAndSaysWhatBecameOfEach) {
  const auto result = finetune("one");
  ASSERT_EQ(result.exit_code, 0) << result.err;
  const auto metrics = finetune_metrics(tuned("one"));
  ASSERT_EQ(metrics.at("sequences").size(), 3U);
  double mean = 0.0;
  for (const auto& sequence : metrics.at("sequences")) {
    const std::string name = sequence.at("name");
    mean += sequence.at("zero_shot").at("graph_ate_m").get<double>() / 3.0;
    EXPECT_NE(result.out.find(name), std::string::npos) << name;
    for (const char* run : {"zero_shot", "adapted"}) {
      testing::CheckedRun checked;
      testing::expect_complete_run(tuned("one") / run / name, checked);
    }
  }
  EXPECT_NEAR(metrics.at("results").at("zero_shot").at("graph_ate_m").get<double>(), mean, 1e-12);
  EXPECT_TRUE(fs::exists(tuned("one") / "report.html"));
}

TEST_F(FinetuneSuite, ProcessesChangeNoByte) {
  ASSERT_EQ(finetune("one").exit_code, 0);
  const auto two = finetune("two", "--jobs 2");
  ASSERT_EQ(two.exit_code, 0) << two.err;
  expect_same("one", "two");
}

TEST_F(FinetuneSuite, MoreProcessesThanSequencesHaveNothingToDo) {
  dir_.write(
      "suite.yaml",
      "name: One\nmetric: euroc\nroot: /\nsequences:\n  - {name: first, path: " + place(0) + "}\n");
  const auto result = finetune("one", "--jobs 2");
  ASSERT_EQ(result.exit_code, 0) << result.err;
  EXPECT_EQ(finetune_metrics(tuned("one")).at("sequences").size(), 1U);
}

TEST_F(FinetuneSuite, KilledInSeveralProcessesItEndsInTheSameBytes) {
  ASSERT_EQ(finetune("one").exit_code, 0);
  for (const char* delay_s : {"2", "3"})
    finetune("two", "--jobs 2 --resume", std::string("timeout -s KILL ") + delay_s);
  const auto last = finetune("two", "--jobs 3 --resume");
  ASSERT_EQ(last.exit_code, 0) << last.err;
  testing::expect_same_files(tuned("one"), tuned("two"), testing::kLearnedFiles);
}

TEST_F(FinetuneSuite, MpiChangesNoByte) {
  if (!built_with_mpi()) GTEST_SKIP() << "built without MPI";
  if (std::system("command -v mpirun >/dev/null 2>&1") != 0) GTEST_SKIP() << "no mpirun here";
  ASSERT_EQ(finetune("one").exit_code, 0);
  for (const char* ranks : {"2", "4"}) {
    const auto result =
        finetune(ranks, "", std::string("mpirun --allow-run-as-root --oversubscribe -n ") + ranks);
    ASSERT_EQ(result.exit_code, 0) << result.err;
    expect_same("one", ranks);
  }
}

TEST_F(FinetuneSuite, RefusesWhatItCannotUse) {
  const auto code = [&](const std::string& arguments) {
    return run_imslam(
               dir_, "finetune " + arguments + " --out " + quoted((dir_.path() / "tuned").string()))
        .exit_code;
  };
  const std::string suite = quoted((dir_.path() / "suite.yaml").string());
  EXPECT_EQ(code(suite + " --root " + quoted((dir_.path() / "nowhere").string())), 3);
  EXPECT_EQ(code(suite + " --jobs 0"), 2);
  EXPECT_EQ(code(suite + " --jobs 2 --set finetune.matcher=heads"), 2);
  EXPECT_EQ(code(quoted((dir_.path() / "no_suite.yaml").string())), 2);
  EXPECT_EQ(code(quoted(testing::simulated_base().sequence.string()) + " --jobs 2"), 2);
  const fs::path lacking = dir_.write(
      "lacking.yaml", "name: L\nmetric: euroc\nroot: .\nsequences:\n  - {name: a, path: gone}\n");
  const auto result = run_imslam(dir_, "finetune " + quoted(lacking.string()));
  EXPECT_EQ(result.exit_code, 3);
  EXPECT_NE(result.err.find("not there: a"), std::string::npos) << result.err;
  EXPECT_FALSE(fs::exists(dir_.path() / "tuned" / "log.csv"));
}

}  // namespace
}  // namespace imslam
