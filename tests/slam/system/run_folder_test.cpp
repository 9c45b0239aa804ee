#include "slam/system/run_folder.hpp"

#include <gtest/gtest.h>

#include "slam/base/error.hpp"
#include "tests/support/temp_dir.hpp"

namespace imslam::system {
namespace {

namespace fs = std::filesystem;

TEST(RunFolder, TwoRunsInTheSameSecondGetTwoFolders) {
  const testing::TempDir dir;
  const auto first = make_run_folder(dir.path(), "MH_01");
  const auto second = make_run_folder(dir.path(), "MH_01");
  EXPECT_NE(first, second);
  EXPECT_TRUE(fs::is_directory(first));
  EXPECT_TRUE(fs::is_directory(second));
}

TEST(RunFolder, ANameCannotLeaveTheRunsFolder) {
  const testing::TempDir dir;
  const auto folder = make_run_folder(dir.path(), "../../etc/<script>");
  EXPECT_EQ(folder.parent_path(), dir.path());
  EXPECT_EQ(safe_name("../a b"), ".._a_b");
}

TEST(RunFolder, RefusesAFolderThatIsNotEmpty) {
  const testing::TempDir dir;
  dir.write("thesis.tex", "precious");
  try {
    make_run_folder({}, "x", dir.path(), true);
    FAIL() << "expected InputError";
  } catch (const InputError& error) {
    EXPECT_EQ(error.code(), ExitCode::kOutput);
  }
}

TEST(RunFolder, ForceReplacesAnEarlierRunOnly) {
  const testing::TempDir dir;
  dir.write("manifest.json", "{}");
  EXPECT_THROW(make_run_folder({}, "x", dir.path(), false), InputError);
  EXPECT_EQ(make_run_folder({}, "x", dir.path(), true), dir.path());
}

TEST(RunFolder, LatestPointsToTheNewestRun) {
  const testing::TempDir dir;
  const auto first = make_run_folder(dir.path(), "a");
  update_latest_link(first);
  const auto second = make_run_folder(dir.path(), "b");
  update_latest_link(second);
  EXPECT_TRUE(fs::equivalent(dir.path() / "latest", second));
}

TEST(RunFolder, SaysWhyAFolderCannotBeMade) {
  const testing::TempDir dir;
  const auto file = dir.write("file", "not a folder");
  try {
    make_run_folder(file / "runs", "x");
    FAIL() << "expected InputError";
  } catch (const InputError& error) {
    EXPECT_EQ(error.code(), ExitCode::kOutput);
    EXPECT_NE(std::string(error.what()).find("--out"), std::string::npos);
  }
}

}  // namespace
}  // namespace imslam::system
