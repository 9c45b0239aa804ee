#include <gtest/gtest.h>

#include "tests/support/command.hpp"

namespace imslam {
namespace {

using testing::run_imslam;
using testing::TempDir;

bool contains(const std::string& text, const std::string& part) {
  return text.find(part) != std::string::npos;
}

TEST(CommandLine, HelpShowsExamplesAndExitCodes) {
  const TempDir dir;
  const auto result = run_imslam(dir, "--help");
  EXPECT_EQ(result.exit_code, 0);
  for (const char* part :
       {"run", "eval", "check", "simulate", "report", "config", "Examples", "Exit codes", "130"}) {
    EXPECT_TRUE(contains(result.out, part)) << part;
  }
}

TEST(CommandLine, EverySubcommandHasHelp) {
  const TempDir dir;
  for (const char* name : {"run", "eval", "check", "simulate", "report", "config"}) {
    const auto result = run_imslam(dir, std::string(name) + " --help");
    EXPECT_EQ(result.exit_code, 0) << name;
    EXPECT_GT(result.out.size(), 200U) << name;
  }
}

TEST(CommandLine, VersionNamesTheGitHash) {
  const TempDir dir;
  const auto result = run_imslam(dir, "--version");
  EXPECT_EQ(result.exit_code, 0);
  EXPECT_TRUE(contains(result.out, "git "));
}

TEST(CommandLine, UnknownOptionsAreUsageErrors) {
  const TempDir dir;
  EXPECT_EQ(run_imslam(dir, "").exit_code, 2);
  EXPECT_EQ(run_imslam(dir, "fly").exit_code, 2);
  EXPECT_EQ(run_imslam(dir, "run --no-such-option").exit_code, 2);
}

TEST(CommandLine, AMistypedCommandOrOptionNamesTheNearest) {
  const TempDir dir;
  const std::pair<const char*, const char*> typed_meant[] = {
      {"rn", "'rn' is unknown; did you mean 'run'?"},
      {"evaluate a b", "did you mean 'eval'?"},
      {"route solv", "did you mean 'solve'?"},
      {"run --thread 3", "'--thread' is unknown; did you mean '--threads'?"},
      {"run --sets=pgo.huber=1", "'--sets' is unknown; did you mean '--set'?"}};
  for (const auto& [typed, meant] : typed_meant) {
    const auto result = run_imslam(dir, typed);
    EXPECT_EQ(result.exit_code, 2) << typed;
    EXPECT_TRUE(contains(result.err, meant)) << typed << ": " << result.err;
  }
  const auto nothing_near = run_imslam(dir, "route fly");
  EXPECT_FALSE(contains(nothing_near.err, "did you mean")) << nothing_near.err;
  EXPECT_TRUE(contains(nothing_near.err, "'fly' is no command of route")) << nothing_near.err;
  EXPECT_TRUE(contains(nothing_near.err, "imslam route --help")) << nothing_near.err;
}

TEST(CommandLine, AnUnknownKeyNamesTheNearest) {
  const TempDir dir;
  const auto result = run_imslam(dir, "config dump --set pgo.hubr=2");
  EXPECT_EQ(result.exit_code, 2);
  EXPECT_TRUE(contains(result.err, "did you mean")) << result.err;
}

TEST(CommandLine, LinksInACircleAndNamesThatAreTooLongHaveTheCodeOfTheirUse) {
  const TempDir dir;
  std::filesystem::create_symlink("loop", dir.path() / "loop");
  for (const std::string& name : {std::string("loop"), std::string(300, 'x')}) {
    const std::string word = testing::quoted((dir.path() / name).string());
    EXPECT_EQ(run_imslam(dir, "config validate --config " + word).exit_code, 2) << name;
    EXPECT_EQ(run_imslam(dir, "check " + word).exit_code, 3) << name;
    EXPECT_EQ(run_imslam(dir, "eval " + word + " " + word).exit_code, 3) << name;
    EXPECT_EQ(run_imslam(dir, "--log-file " + word + " config dump").exit_code, 6) << name;
  }
}

TEST(CommandLine, AConfigFileErrorNamesTheLine) {
  const TempDir dir;
  const auto file = dir.write("bad.yaml", "pgo:\n  no_such_key: 1\n");
  const auto result = run_imslam(dir, "config validate --config " + testing::quoted(file.string()));
  EXPECT_EQ(result.exit_code, 2);
  EXPECT_TRUE(contains(result.err, "bad.yaml:2")) << result.err;
}

TEST(CommandLine, TheDumpedConfigurationLoadsBack) {
  const TempDir dir;
  const auto dumped = run_imslam(dir, "config dump");
  ASSERT_EQ(dumped.exit_code, 0);
  const auto file = dir.write("all.yaml", dumped.out);
  const auto again = run_imslam(dir, "config diff --config " + testing::quoted(file.string()));
  EXPECT_EQ(again.exit_code, 0) << again.err;
  EXPECT_EQ(again.out, "");
}

TEST(CommandLine, EveryShippedConfigurationLoads) {
  const TempDir dir;
  int files = 0;
  for (const auto& entry : std::filesystem::directory_iterator("configs")) {
    if (entry.path().extension() != ".yaml") continue;
    ++files;
    // Trainings have options of their own: train_vo.yaml is for `imslam train vo`.
    const std::string name = entry.path().stem().string();
    // Suites are for `imslam bench`.
    const bool training = name.rfind("train_", 0) == 0;
    const bool suite = name.rfind("suite_", 0) == 0;
    const std::string command = training ? "train " + name.substr(6) + " --list --config "
                                : suite  ? "bench --list "
                                         : "config validate --config ";
    const auto result = run_imslam(dir, command + testing::quoted(entry.path().string()));
    EXPECT_EQ(result.exit_code, 0) << result.err;
  }
  EXPECT_GE(files, 4);
}

TEST(CommandLine, TheEnvironmentLiesBetweenFileAndSet) {
  const TempDir dir;
  const auto file = dir.write("some.yaml", "system:\n  map_voxel_m: 0.5\n");
  const std::string with_file = "config dump --config " + testing::quoted(file.string());
  const std::string environment = "IMSLAM_SYSTEM_MAP_VOXEL_M=0.7";
  EXPECT_TRUE(contains(run_imslam(dir, with_file).out, "map_voxel_m: 0.5"));
  EXPECT_TRUE(contains(run_imslam(dir, with_file, environment).out, "map_voxel_m: 0.7"));
  EXPECT_TRUE(
      contains(run_imslam(dir, with_file + " --set system.map_voxel_m=0.9", environment).out,
               "map_voxel_m: 0.9"));
}

}  // namespace
}  // namespace imslam
