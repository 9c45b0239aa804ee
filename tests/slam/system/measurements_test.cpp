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
