#include "slam/system/measurements.hpp"

#include <gtest/gtest.h>

#include "tests/support/numeric_jacobian.hpp"

namespace imslam::system {
namespace {

using testing::expect_near;

const lie::SE3d kStep =
    lie::SE3d::exp((lie::SE3d::Tangent() << 0.5, 0.1, -0.2, 0.05, -0.1, 0.2).finished());

RelativeMotion motion(std::int64_t time0_ns, std::int64_t time1_ns, const lie::SE3d& T) {
  RelativeMotion result;
  result.time0_ns = time0_ns;
  result.time1_ns = time1_ns;
  result.T_body0_body1 = T;
  result.valid = true;
  return result;
}

TEST(Measurements, FindsFramesByTheirStamp) {
  Measurements measurements;
  measurements.times_ns = {10, 20, 30};
  EXPECT_EQ(measurements.frame_at(20), 1U);
  EXPECT_EQ(measurements.frame_at(25), std::nullopt);
  EXPECT_EQ(measurements.frame_at(31), std::nullopt);
}

std::vector<ImuSample> samples_at(std::initializer_list<std::int64_t> times_ns) {
  std::vector<ImuSample> samples;
  for (const std::int64_t time_ns : times_ns) {
    samples.emplace_back();
    samples.back().time_ns = time_ns;
  }
  return samples;
}

TEST(Measurements, LentReadingsInOneArrayAreNotCopied) {
  const std::vector<ImuSample> kept = samples_at({10, 20, 30});
  Measurements measurements;
  EXPECT_TRUE(measurements.readings().empty());
  measurements.lend_imu(kept[1]);
  measurements.lend_imu(kept[2]);
  EXPECT_EQ(measurements.readings().begin(), &kept[1]);
  EXPECT_EQ(measurements.readings().end(), kept.data() + kept.size());
}

TEST(Measurements, LentReadingsWithAHoleBetweenThemAreCopied) {
  const std::vector<ImuSample> kept = samples_at({10, 20, 30, 40});
  Measurements measurements;
  for (const std::size_t i : {0U, 1U, 3U}) measurements.lend_imu(kept[i]);
  const imu::ImuRange readings = measurements.readings();
  ASSERT_EQ(readings.size(), 3U);
  EXPECT_EQ(readings[0].time_ns, 10);
  EXPECT_EQ(readings[1].time_ns, 20);
  EXPECT_EQ(readings[2].time_ns, 40);
  EXPECT_EQ(readings.begin(), measurements.imu.data());
}

TEST(ChainOdometry, MultipliesTheMotions) {
  Measurements measurements;
  measurements.times_ns = {0, 100, 200};
  measurements.odometry = {motion(0, 100, kStep), motion(100, 200, kStep)};
  const auto chain = chain_odometry(measurements);
  ASSERT_EQ(chain.trajectory.size(), 3U);
  expect_near(chain.trajectory.poses[2].matrix(), (kStep * kStep).matrix(), 1e-12);
}

TEST(ChainOdometry, PutsFramesInsideALongMotionOnItsScrew) {
  Measurements measurements;
  measurements.times_ns = {0, 100, 200};
  measurements.odometry = {motion(0, 200, kStep * kStep)};
  const auto chain = chain_odometry(measurements);
  expect_near(chain.trajectory.poses[1].matrix(), kStep.matrix(), 1e-12);
  expect_near(chain.trajectory.poses[2].matrix(), (kStep * kStep).matrix(), 1e-12);
  EXPECT_TRUE(chain.covered[1] && chain.covered[2]);
}

TEST(ChainOdometry, GoesOnAtTheLastRateWhereNothingWasMeasured) {
  Measurements measurements;
  measurements.times_ns = {0, 100, 200, 300};
  measurements.odometry = {motion(0, 100, kStep), motion(200, 300, kStep)};
  const auto chain = chain_odometry(measurements);
  expect_near(chain.trajectory.poses[3].matrix(), (kStep * kStep * kStep).matrix(), 1e-12);
  EXPECT_TRUE(chain.covered[1]);
  EXPECT_FALSE(chain.covered[2]);
  EXPECT_TRUE(chain.covered[3]);
}

TEST(ChainOdometry, OfNothingIsEmpty) {
  EXPECT_EQ(chain_odometry(Measurements()).trajectory.size(), 0U);
}

}  // namespace
}  // namespace imslam::system
