#include "datasets/imu_csv.hpp"

#include <gtest/gtest.h>

#include "tests/datasets/expect_error.hpp"
#include "tests/support/temp_dir.hpp"

namespace imslam::datasets {
namespace {

using imslam::testing::expect_input_error;
using imslam::testing::TempDir;

constexpr std::int64_t kMs = 1'000'000;

std::string row(std::int64_t time_ns, double value = 0.1) {
  return std::to_string(time_ns) + "," + std::to_string(value) + ",0.2,0.3,1,2,9.81\n";
}

std::string clean_text() {
  std::string text;
  for (int i = 0; i < 20; ++i) text += row(i * 5 * kMs, 0.01 * i);
  return text;
}

void expect_same(const std::vector<ImuSample>& actual, const std::vector<ImuSample>& expected) {
  ASSERT_EQ(actual.size(), expected.size());
  for (std::size_t i = 0; i < actual.size(); ++i) {
    EXPECT_EQ(actual[i].time_ns, expected[i].time_ns);
    EXPECT_EQ(actual[i].angular_velocity, expected[i].angular_velocity);  // bit for bit
    EXPECT_EQ(actual[i].linear_acceleration, expected[i].linear_acceleration);
  }
}

ImuTable read(const std::string& text) {
  const TempDir dir;
  return read_imu_csv(dir.write("imu.csv", text));
}

TEST(ReadImuCsv, ReadsEveryColumn) {
  const ImuTable table = read("#t,...\n5,0.1,0.2,0.3,1,2,9.81\n");
  ASSERT_EQ(table.samples.size(), 1U);
  EXPECT_EQ(table.samples[0].time_ns, 5);
  EXPECT_EQ(table.samples[0].angular_velocity, Eigen::Vector3d(0.1, 0.2, 0.3));
  EXPECT_EQ(table.samples[0].linear_acceleration, Eigen::Vector3d(1, 2, 9.81));
  EXPECT_EQ(table.cleaning.dropped(), 0U);
}

TEST(ReadImuCsv, SwappedAndRepeatedRowsGiveTheSameSamplesAsTheCleanFile) {
  const auto clean = read(clean_text());
  std::string swapped;
  std::string repeated;
  for (int i = 0; i < 20; ++i) {
    const int j = i % 2 == 0 ? i + 1 : i - 1;
    swapped += row(j * 5 * kMs, 0.01 * j);
    repeated += row(i * 5 * kMs, 0.01 * i) + (i % 3 == 0 ? row(i * 5 * kMs, 0.01 * i) : "");
  }
  const ImuTable sorted = read(swapped);
  expect_same(sorted.samples, clean.samples);
  EXPECT_EQ(sorted.cleaning.late, 10U);
  EXPECT_EQ(sorted.cleaning.dropped(), 0U);
  const ImuTable unique = read(repeated);
  expect_same(unique.samples, clean.samples);
  EXPECT_EQ(unique.cleaning.repeated, 7U);
}

TEST(ReadImuCsv, KeepsTheFirstOfConflictingSamples) {
  const ImuTable table = read(row(0, 1) + row(0, 2) + row(0, 1) + row(5, 3));
  ASSERT_EQ(table.samples.size(), 2U);
  EXPECT_EQ(table.samples[0].angular_velocity.x(), 1.0);
  EXPECT_EQ(table.cleaning.conflicting, 1U);
  EXPECT_EQ(table.cleaning.repeated, 1U);
}

TEST(ReadImuCsv, DropsAndCountsWhatIsNotFinite) {
  const ImuTable table = read(row(0) + "5,nan,0,0,0,0,9\n6,0,0,0,0,inf,9\n" + row(10));
  EXPECT_EQ(table.samples.size(), 2U);
  EXPECT_EQ(table.cleaning.not_finite, 2U);
  EXPECT_EQ(table.cleaning.dropped(), 2U);
}

TEST(ReadImuCsv, SortsALatenessOf100MillisecondsAndRefusesMore) {
  EXPECT_EQ(read(row(100 * kMs) + row(0)).samples.front().time_ns, 0);
  expect_input_error([] { read(row(0) + row(101 * kMs) + row(0)); }, ExitCode::kData,
                     {"imu.csv:3", "0.101 s before an earlier line", "sort the file"});
}

TEST(ReadImuCsv, SkipsALineThatIsCutOffAtTheEnd) {
  const ImuTable table = read(row(0) + row(5) + "10,0.1,0.2");
  EXPECT_EQ(table.samples.size(), 2U);
  EXPECT_TRUE(table.cleaning.cut_off);
}

TEST(ReadImuCsv, RefusesALineThatIsCutOffInTheMiddle) {
  expect_input_error([] { read(row(0) + "5,0.1,0.2\n" + row(10)); }, ExitCode::kData,
                     {"imu.csv:2:1", "expected 7 columns", "found 3"});
}

}  // namespace
}  // namespace imslam::datasets
