#include "slam/system/inertial_motions.hpp"

#include <gtest/gtest.h>

#include "slam/base/random.hpp"
#include "tests/slam/system/sine_measurements.hpp"

namespace imslam::system {
namespace {

using testing::SineWorld;
using Vector9d = Eigen::Matrix<double, 9, 1>;

ImuMotion interval(const Measurements& measurements, std::size_t first) {
  return integrate_interval(measurements, measurements.times_ns[first],
                            measurements.times_ns[first + 1], {}, 0.0, {});
}

/// The slope at the very ends of the interval.
Vector9d tangent(const Measurements& measurements, std::size_t first) {
  return imu::preintegrate(measurements.readings(), measurements.times_ns[first],
                           measurements.times_ns[first + 1], {}, measurements.imu_noise)
      .J_time_offset;
}

TEST(IntegrateInterval, TheSlopeByTheTimeOffsetIsThatOfTheMotion) {
  const Measurements measurements = SineWorld().measure();
  for (std::size_t i = 20; i < 100; i += 7) {
    const ImuMotion motion = interval(measurements, i);
    const Vector9d expected = tangent(measurements, i);
    EXPECT_LT((motion.J_time_offset - expected).norm(), 0.02 * expected.norm() + 1e-3) << i;
    EXPECT_FALSE(motion.degraded);
  }
}

TEST(IntegrateInterval, NoiseIsNoChangeOfMotion) {
  Measurements measurements = SineWorld().measure();
  Random random(3);
  for (ImuSample& sample : measurements.imu) {  // a body that shakes where it stands
    sample.angular_velocity = 0.01 * random.normal3();
    sample.linear_acceleration = Eigen::Vector3d(0.0, 0.0, 9.81) + 0.3 * random.normal3();
  }
  double squares = 0.0;
  double at_the_ends = 0.0;
  for (std::size_t i = 20; i < 100; ++i) {
    squares += interval(measurements, i).J_time_offset.segment<3>(3).squaredNorm();
    at_the_ends += tangent(measurements, i).segment<3>(3).squaredNorm();
  }
  // The mean of ten readings has a tenth of their variance.
  EXPECT_LT(squares, 0.2 * at_the_ends);
  EXPECT_GT(squares, 0.02 * at_the_ends);
}

TEST(IntegrateInterval, WithoutTheFutureTheSlopeIsThatOfThePast) {
  Measurements measurements = SineWorld().measure();
  const std::size_t newest = 60;
  const std::int64_t now_ns = measurements.times_ns[newest + 1];
  const Vector9d expected = interval(measurements, newest).J_time_offset;
  while (measurements.imu.back().time_ns > now_ns) measurements.imu.pop_back();
  const ImuMotion motion = interval(measurements, newest);
  ASSERT_TRUE(motion.valid);
  EXPECT_FALSE(motion.degraded);
  EXPECT_GT(expected.norm(), 0.1);
  EXPECT_LT((motion.J_time_offset - expected).norm(), 0.15 * expected.norm());
}

}  // namespace
}  // namespace imslam::system
