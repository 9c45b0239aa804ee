#pragma once

#include <cstdlib>
#include <filesystem>
#include <string>

namespace imslam::testing {

/// Real data and golden files that are not part of the project: `../shared` beside the checkout,
/// or where IMSLAM_TEST_DATA points (its `data` folder) / IMSLAM_TEST_FIXTURES.
inline std::filesystem::path test_data() {
  if (const char* folder = std::getenv("IMSLAM_TEST_DATA")) return folder;
  return "../shared/data";
}

inline std::filesystem::path test_fixtures() {
  if (const char* folder = std::getenv("IMSLAM_TEST_FIXTURES")) return folder;
  return "../shared/fixtures";
}

}  // namespace imslam::testing

/// Skips the test, saying why, where real data is absent.
#define IMSLAM_NEEDS(path) \
  if (!std::filesystem::exists(path)) GTEST_SKIP() << "not here: " << (path).string()
