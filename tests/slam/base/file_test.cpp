#include "slam/base/file.hpp"

#include <gtest/gtest.h>
#include <sys/stat.h>

#include "slam/base/error.hpp"
#include "tests/support/temp_dir.hpp"

namespace imslam {
namespace {

namespace fs = std::filesystem;

std::size_t entries(const fs::path& folder) {
  return static_cast<std::size_t>(
      std::distance(fs::directory_iterator(folder), fs::directory_iterator()));
}

ExitCode code_of_write(const fs::path& file) {
  try {
    write_file_atomic(file, "new");
  } catch (const InputError& error) {
    EXPECT_NE(std::string(error.what()).find(file.filename().string()), std::string::npos);
    return error.code();
  }
  return ExitCode::kOk;
}

TEST(WriteFileAtomic, ReadsBackByteForByte) {
  const testing::TempDir folder;
  std::string content("bytes \0 with zero\r\n", 19);
  for (int i = 0; i < 200000; ++i) content += static_cast<char>(i % 256);
  write_file_atomic(folder.path() / "a.bin", content);
  EXPECT_EQ(read_file(folder.path() / "a.bin"), content);
  write_file_atomic(folder.path() / "a.bin", "");
  EXPECT_EQ(read_file(folder.path() / "a.bin"), "");
}

TEST(WriteFileAtomic, LeavesNoTemporaryFileBehind) {
  const testing::TempDir folder;
  write_file_atomic(folder.path() / "a", "1");
  write_file_atomic(folder.path() / "a", "2");
  EXPECT_EQ(entries(folder.path()), 1U);
  EXPECT_EQ(read_file(folder.path() / "a"), "2");
}

TEST(WriteFileAtomic, AMissingFolderIsAnOutputError) {
  const testing::TempDir folder;
  EXPECT_EQ(code_of_write(folder.path() / "no" / "a"), ExitCode::kOutput);
  EXPECT_EQ(entries(folder.path()), 0U);
}

TEST(WriteFileAtomic, AFailedReplacementKeepsTheOldAndCleansUp) {
  const testing::TempDir folder;
  folder.write("target/old", "old");  // a folder that is not empty cannot be replaced by a file
  EXPECT_EQ(code_of_write(folder.path() / "target"), ExitCode::kOutput);
  EXPECT_EQ(read_file(folder.path() / "target/old"), "old");
  EXPECT_EQ(entries(folder.path()), 1U);
}

TEST(WriteFileAtomic, AReadOnlyFolderKeepsTheOldFile) {
  const testing::TempDir folder;
  const auto file = folder.write("a", "old");
  ::chmod(folder.path().c_str(), 0500);
  const bool root = ::geteuid() == 0;  // nothing is read-only to root
  if (!root) {
    EXPECT_EQ(code_of_write(file), ExitCode::kOutput);
    EXPECT_EQ(read_file(file), "old");
  }
  ::chmod(folder.path().c_str(), 0700);
  if (root) GTEST_SKIP() << "root may write everywhere";
}

TEST(WriteFileAtomic, AFullDeviceIsAnOutputError) {
  if (!fs::exists("/dev/full")) GTEST_SKIP() << "no /dev/full";
  const testing::TempDir folder;
  // The temporary file's name is known: make it lead to a device that is always full.
  const auto temporary = folder.path() / (".a." + std::to_string(::getpid()) + ".tmp");
  fs::create_symlink("/dev/full", temporary);
  folder.write("a", "old");
  EXPECT_NE(code_of_write(folder.path() / "a"), ExitCode::kOk);
  EXPECT_EQ(read_file(folder.path() / "a"), "old");
}

TEST(ReadFile, EndlessFilesEndInAMessage) {
  if (!fs::exists("/dev/zero")) GTEST_SKIP() << "no /dev/zero";
  EXPECT_THROW(read_file("/dev/zero", 1U << 20U), InputError);
}

TEST(ReadFile, TheLimitItselfIsAllowed) {
  const testing::TempDir folder;
  const auto file = folder.write("a", "12345");
  EXPECT_EQ(read_file(file, 5), "12345");
  EXPECT_THROW(read_file(file, 4), InputError);
}

TEST(ReadFile, FoldersAndMissingFilesAreInputErrors) {
  const testing::TempDir folder;
  EXPECT_THROW(read_file(folder.path()), InputError);
  EXPECT_THROW(read_file(folder.path() / "missing"), InputError);
}

TEST(ReadFile, LinksInACircleAndNamesThatAreTooLongAreDataErrors) {
  const testing::TempDir folder;
  fs::create_symlink("loop", folder.path() / "loop");
  for (const std::string& name : {std::string("loop"), std::string(300, 'x')}) {
    try {
      read_file(folder.path() / name);
      ADD_FAILURE() << "expected InputError of " << name;
    } catch (const InputError& error) {
      EXPECT_EQ(error.code(), ExitCode::kData) << error.what();
    }
  }
}

// From FIPS 180-2, appendix B.
TEST(Sha256, MatchesTheStandard) {
  EXPECT_EQ(sha256("abc"), "ba7816bf8f01cfea414140de5dae2223b00361a396177a9cb410ff61f20015ad");
  EXPECT_EQ(sha256("abcdbcdecdefdefgefghfghighijhijkijkljklmklmnlmnomnopnopq"),
            "248d6a61d20638b8e5c026930c3e6039a33ce45964ff2167f6ecedd419db06c1");
}

TEST(Sha256, OfAFileIsThatOfItsContent) {
  const testing::TempDir folder;
  const std::string content(200001, 'x');
  EXPECT_EQ(sha256_of_file(folder.write("a", content)), sha256(content));
  EXPECT_THROW(sha256_of_file(folder.path() / "missing"), InputError);
}

}  // namespace
}  // namespace imslam
