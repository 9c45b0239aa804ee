#include "slam/system/run_folder.hpp"

#include <gtest/gtest.h>

#include "slam/base/error.hpp"
#include "slam/base/file.hpp"
#include "tests/support/temp_dir.hpp"

namespace imslam::system {
namespace {

namespace fs = std::filesystem;

TEST(RunFolder, TwoRunsInTheSameSecondGetTwoFolders) {
  const testing::TempDir dir;
  const auto first = make_run_folder(dir.path(), "MH_01");
  const auto second = make_run_folder(dir.path(), "MH_01");
  EXPECT_NE(first.path(), second.path());
  EXPECT_TRUE(fs::is_directory(first.path()));
  EXPECT_TRUE(fs::is_directory(second.path()));
}

TEST(RunFolder, ANameCannotLeaveTheRunsFolder) {
  const testing::TempDir dir;
  const auto folder = make_run_folder(dir.path(), "../../etc/<script>");
  EXPECT_EQ(folder.path().parent_path(), dir.path());
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

TEST(RunFolder, ALinkInACircleAndANameThatIsTooLongAreOutputErrors) {
  const testing::TempDir dir;
  fs::create_directory_symlink("loop", dir.path() / "loop");
  for (const std::string& name : {std::string("loop"), std::string(300, 'x')}) {
    try {
      make_run_folder({}, "x", dir.path() / name);
      ADD_FAILURE() << "expected InputError of " << name;
    } catch (const InputError& error) {
      EXPECT_EQ(error.code(), ExitCode::kOutput) << error.what();
    }
  }
}

TEST(RunFolder, ForceReplacesAnEarlierRunOnceTheNewOneIsComplete) {
  const testing::TempDir dir;
  const fs::path out = dir.path() / "run";
  dir.write("run/manifest.json", "old");
  EXPECT_THROW(make_run_folder({}, "x", out, false), InputError);
  auto folder = make_run_folder({}, "x", out, true);
  EXPECT_EQ(folder.path().filename(), "run");  // reports are named after it
  write_file_atomic(folder.path() / "manifest.json", "new");
  EXPECT_EQ(read_file(out / "manifest.json"), "old");
  folder.publish();
  EXPECT_EQ(folder.path(), fs::canonical(out));
  EXPECT_EQ(read_file(out / "manifest.json"), "new");
}

TEST(RunFolder, ARunThatFailsLeavesTheEarlierOneAlone) {
  const testing::TempDir dir;
  dir.write("run/manifest.json", "old");
  {
    const auto folder = make_run_folder({}, "x", dir.path() / "run", true);
    write_file_atomic(folder.path() / "manifest.json", "new");
  }
  EXPECT_EQ(read_file(dir.path() / "run" / "manifest.json"), "old");
  EXPECT_EQ(std::distance(fs::directory_iterator(dir.path()), fs::directory_iterator()), 1);
}

TEST(RunFolder, IsGivenToOneRunAtATime) {
  const testing::TempDir dir;
  const fs::path out = dir.path() / "run";
  {
    const auto first = make_run_folder({}, "x", out);
    try {
      make_run_folder({}, "x", out);
      FAIL() << "expected InputError";
    } catch (const InputError& error) {
      EXPECT_EQ(error.code(), ExitCode::kOutput);
      EXPECT_NE(std::string(error.what()).find("another run"), std::string::npos) << error.what();
    }
  }
  EXPECT_EQ(make_run_folder({}, "x", out).path(), out);
}

TEST(RunFolder, LatestPointsToTheNewestRun) {
  const testing::TempDir dir;
  const auto first = make_run_folder(dir.path(), "a");
  update_latest_link(first.path());
  const auto second = make_run_folder(dir.path(), "b");
  update_latest_link(second.path());
  EXPECT_TRUE(fs::equivalent(dir.path() / "latest", second.path()));
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
