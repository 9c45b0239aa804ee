#include "slam/report/pcd_reader.hpp"

#include <gtest/gtest.h>

#include <cstring>

#include "slam/base/error.hpp"
#include "tests/support/temp_dir.hpp"

namespace imslam::report {
namespace {

using imslam::testing::TempDir;

std::string bytes_of(const std::vector<float>& values) {
  std::string bytes(values.size() * sizeof(float), '\0');
  std::memcpy(bytes.data(), values.data(), bytes.size());
  return bytes;
}

std::string header(const std::string& points, const std::string& data) {
  return "# .PCD v0.7\nVERSION 0.7\nFIELDS x y z intensity\nSIZE 4 4 4 4\nTYPE F F F F\nCOUNT 1 1 "
         "1 "
         "1\nWIDTH 2\nHEIGHT 1\nVIEWPOINT 0 0 0 1 0 0 0\nPOINTS " +
         points + "\nDATA " + data + "\n";
}

/// What the message says about `content`, "" if it is accepted.
std::string complaint(const std::string& content) {
  const TempDir folder;
  try {
    read_pcd(folder.write("map.pcd", content), 10);
  } catch (const InputError& problem) {
    return problem.what();
  }
  return "";
}

TEST(PcdReader, BinaryAndAsciiGiveTheSame) {
  const TempDir folder;
  const auto binary =
      folder.write("b.pcd", header("2", "binary") + bytes_of({1, 2, 3, 200, -4, 5.5F, 6, 10}));
  const auto ascii = folder.write("a.pcd", header("2", "ascii") + "1 2 3 200\n-4 5.5 6 10\n");
  for (const auto& file : {binary, ascii}) {
    const PointCloud cloud = read_pcd(file, 10);
    ASSERT_EQ(cloud.points.size(), 2U);
    EXPECT_EQ(cloud.points[1], Eigen::Vector3f(-4, 5.5F, 6));
    EXPECT_EQ(cloud.intensities, (std::vector<float>{200, 10}));
    EXPECT_EQ(cloud.total, 2U);
  }
}

TEST(PcdReader, SkipsOtherFieldsAndPointsThatAreNotFinite) {
  const TempDir folder;
  const auto file = folder.write(
      "map.pcd",
      "FIELDS normal x y z\nSIZE 4 4 4 4\nTYPE F F F F\nCOUNT 3 1 1 1\nPOINTS 3\nDATA ascii\n"
      "9 9 9 1 2 3\n9 9 9 nan 2 3\n9 9 9 4 5 6\n");
  const PointCloud cloud = read_pcd(file, 10);
  ASSERT_EQ(cloud.points.size(), 2U);
  EXPECT_EQ(cloud.points[0], Eigen::Vector3f(1, 2, 3));
  EXPECT_EQ(cloud.points[1], Eigen::Vector3f(4, 5, 6));
  EXPECT_TRUE(cloud.intensities.empty());
}

TEST(PcdReader, ThinsEvenlyInBothEncodings) {
  const TempDir folder;
  std::vector<float> values;
  std::string lines;
  for (int i = 0; i < 1000; ++i) {
    values.insert(values.end(), {static_cast<float>(i), 0, 0, 0});
    lines += std::to_string(i) + " 0 0 0\n";
  }
  const auto binary = folder.write("b.pcd", header("1000", "binary") + bytes_of(values));
  const auto ascii = folder.write("a.pcd", header("1000", "ascii") + lines);
  for (const auto& file : {binary, ascii}) {
    const PointCloud cloud = read_pcd(file, 7);
    ASSERT_EQ(cloud.points.size(), 7U);
    for (std::size_t i = 0; i < 7; ++i) {
      EXPECT_EQ(cloud.points[i].x(), static_cast<float>(i * 1000 / 7));
    }
    EXPECT_EQ(cloud.total, 1000U);
  }
}

TEST(PcdReader, RefusesWhatItCannotTrust) {
  const std::string good = bytes_of({1, 2, 3, 4, 5, 6, 7, 8});
  EXPECT_EQ(complaint(header("2", "binary") + good), "");
  EXPECT_NE(complaint(header("3", "binary") + good).find("found 32 bytes"), std::string::npos);
  EXPECT_NE(complaint(header("999999999999", "binary") + good).find("bytes"), std::string::npos);
  EXPECT_NE(complaint(header("-1", "binary")).find("map.pcd:10: expected a whole number"),
            std::string::npos);
  EXPECT_NE(complaint(header("99999999999999999999", "ascii")).find(":10:"), std::string::npos);
  EXPECT_NE(complaint(header("2", "binary_compressed") + good).find("DATA ascii or DATA binary"),
            std::string::npos);
  EXPECT_NE(complaint(header("2", "ascii") + "1 2 3 4\n").find("found the end"), std::string::npos);
  EXPECT_NE(complaint(header("1", "ascii") + "1 2 3\n").find(":12: expected 4 numbers"),
            std::string::npos);
  EXPECT_NE(complaint(header("1", "ascii") + "1 2 z 4\n").find("expected a number for z"),
            std::string::npos);
  EXPECT_NE(complaint(""), "");
  EXPECT_NE(complaint("POINTS 1\nDATA ascii\n").find("FIELDS"), std::string::npos);
  EXPECT_NE(complaint("FIELDS x y\nPOINTS 0\nDATA ascii\n").find("x y z"), std::string::npos);
  EXPECT_NE(complaint("FIELDS x y z\nSIZE 8 8 8\nPOINTS 0\nDATA ascii\n").find("4-byte float"),
            std::string::npos);
  EXPECT_NE(complaint("FIELDS x y z\nSIZE 4 4\n").find("expected 3 values"), std::string::npos);
  EXPECT_NE(complaint(std::string(100000, 'x')).find("endless line"), std::string::npos);
}

TEST(PcdReader, EveryTruncationEndsInAMessage) {
  const std::string whole = header("2", "binary") + bytes_of({1, 2, 3, 4, 5, 6, 7, 8});
  for (std::size_t size = 0; size < whole.size(); ++size) {
    EXPECT_NE(complaint(whole.substr(0, size)), "") << size;
  }
}

}  // namespace
}  // namespace imslam::report
