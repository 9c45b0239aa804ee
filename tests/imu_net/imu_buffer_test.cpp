#include "imu_net/imu_buffer.hpp"

#include <gtest/gtest.h>

namespace imslam::imu {
namespace {

std::vector<ImuSample> at_times(std::initializer_list<std::int64_t> times) {
  std::vector<ImuSample> samples;
  for (const std::int64_t time : times) {
    samples.emplace_back();
    samples.back().time_ns = time;
  }
  return samples;
}

TEST(ImuRange, AroundKeepsOneSampleOnEitherSide) {
  const auto samples = at_times({10, 20, 30, 40, 50, 60});
  const ImuRange around = ImuRange(samples).around(25, 45);
  EXPECT_EQ(around.begin()->time_ns, 20);
  EXPECT_EQ((around.end() - 1)->time_ns, 50);
}

TEST(ImuRange, AroundNeedsNoNeighbourWhereAStampIsHit) {
  const auto samples = at_times({10, 20, 30, 40, 50, 60});
  const ImuRange around = ImuRange(samples).around(20, 40);
  EXPECT_EQ(around.begin()->time_ns, 20);
  EXPECT_EQ((around.end() - 1)->time_ns, 40);
}

TEST(ImuRange, AroundTakesWhatThereIs) {
  const auto samples = at_times({10, 20});
  EXPECT_EQ(ImuRange(samples).around(0, 100).size(), 2U);
  EXPECT_EQ(ImuRange(samples).around(0, 5).size(), 1U);
  EXPECT_EQ(ImuRange(samples).around(30, 40).size(), 1U);
  EXPECT_TRUE(ImuRange().around(0, 5).empty());
}

TEST(ImuBuffer, RefusesStampsThatDoNotIncrease) {
  ImuBuffer buffer(at_times({10, 20, 20, 15, 30}));
  EXPECT_EQ(buffer.size(), 3U);
  EXPECT_FALSE(buffer.append(at_times({30})[0]));
  EXPECT_TRUE(buffer.append(at_times({31})[0]));
}

TEST(ImuBuffer, DropsOldSamplesButKeepsTheOneBeforeTheTime) {
  ImuBuffer buffer;
  for (int i = 0; i < 1000; ++i) {
    ImuSample sample;
    sample.time_ns = 10 * i;
    buffer.append(sample);
    buffer.drop_before(10 * i - 45);
    ASSERT_LE(buffer.size(), 6U);
  }
  EXPECT_EQ(buffer.samples().begin()->time_ns, 9940);
  EXPECT_EQ((buffer.samples().end() - 1)->time_ns, 9990);
}

TEST(ImuBuffer, DroppingEverythingKeepsTheNewest) {
  ImuBuffer buffer(at_times({10, 20, 30}));
  buffer.drop_before(1000);
  ASSERT_EQ(buffer.size(), 1U);
  EXPECT_EQ(buffer.samples()[0].time_ns, 30);
  ImuBuffer empty;
  empty.drop_before(5);
  EXPECT_TRUE(empty.empty());
}

}  // namespace
}  // namespace imslam::imu
