#include <gtest/gtest.h>

#include <algorithm>
#include <limits>

#include "imu_net/preintegration.hpp"
#include "tests/imu_net/synthetic_motion.hpp"
#include "tests/support/numeric_jacobian.hpp"

namespace imslam::imu {
namespace {

using imslam::testing::expect_near;
using imslam::testing::numeric_jacobian;
using testing::SineMotion;
using testing::stamp;
using Vector9d = Eigen::Matrix<double, 9, 1>;

ImuMotion integrate(const std::vector<ImuSample>& samples, double t0, double t1) {
  return preintegrate(samples, stamp(t0), stamp(t1), ImuBias{}, ImuNoise{});
}

std::vector<ImuSample> without(std::vector<ImuSample> samples, double t0, double t1) {
  const auto inside = [&](const ImuSample& s) {
    return s.time_ns > stamp(t0) && s.time_ns < stamp(t1);
  };
  samples.erase(std::remove_if(samples.begin(), samples.end(), inside), samples.end());
  return samples;
}

/// Squared error in standard deviations; 9 on average if the covariance is honest.
double normalized_error(const ImuMotion& motion, const ImuMotion& truth) {
  const Vector9d error = difference(motion, truth);
  return error.dot(motion.covariance.ldlt().solve(error));
}

TEST(PreintegrateGap, AShortGapIsInterpolatedQuietly) {
  const SineMotion body;
  const auto samples = without(body.samples(0.0, 2.0, 200.0), 0.31, 0.35);
  const ImuMotion motion = integrate(samples, 0.3, 0.4);
  ASSERT_TRUE(motion.valid);
  EXPECT_FALSE(motion.degraded);
  EXPECT_LT(difference(motion, body.truth(0.3, 0.4)).norm(), 1e-3);
}

TEST(PreintegrateGap, LongGapsAreBridgedWithHonestCovariance) {
  const SineMotion body;
  for (const double gap_s : {0.02, 0.05, 0.1, 0.5, 1.0}) {
    for (const double start : {0.3, 0.9, 1.7, 2.6}) {
      const auto samples = without(body.samples(0.0, 5.0, 200.0), start, start + gap_s);
      const double t1 = start + gap_s + 0.02;
      const ImuMotion motion = integrate(samples, start - 0.02, t1);
      ASSERT_TRUE(motion.valid);
      EXPECT_EQ(motion.degraded, gap_s > 0.0501) << gap_s;
      EXPECT_LT(normalized_error(motion, body.truth(start - 0.02, t1)), 25.0) << gap_s;
    }
  }
}

TEST(PreintegrateGap, CovarianceGrowsWithTheGapAndWithTheMotion) {
  const auto variance = [](double strength, double gap_s) {
    const auto samples = without(SineMotion(strength).samples(0.0, 3.0, 200.0), 1.0, 1.0 + gap_s);
    return integrate(samples, 0.9, 2.4).covariance.diagonal().head<6>().eval();
  };
  for (const double gap_s : {0.05, 0.1, 0.3}) {
    EXPECT_TRUE((variance(1.0, 2 * gap_s).array() > variance(1.0, gap_s).array()).all());
    EXPECT_TRUE((variance(1.0, gap_s).array() > variance(0.3, gap_s).array()).all());
  }
}

TEST(PreintegrateGap, AnIntervalInsideTheGapIsBridgedToo) {
  const SineMotion body;
  const auto samples = without(body.samples(0.0, 3.0, 200.0), 1.0, 1.5);
  const ImuMotion motion = integrate(samples, 1.2, 1.25);
  ASSERT_TRUE(motion.valid);
  EXPECT_TRUE(motion.degraded);
  EXPECT_LT(normalized_error(motion, body.truth(1.2, 1.25)), 25.0);
}

/// Bridged in one piece or in twenty: the bridge errs alike, so its turn is known as well.
TEST(PreintegrateGap, IntervalsThatShareAGapAreNotTakenForIndependent) {
  const SineMotion body;
  const auto rotation_variance = [](const std::vector<ImuSample>& samples, int pieces) {
    double sum = 0.0;
    for (int i = 0; i < pieces; ++i) {
      const double t0 = 1.0 + static_cast<double>(i) / pieces;
      const double t1 = 1.0 + static_cast<double>(i + 1) / pieces;
      sum += integrate(samples, t0, t1).covariance.topLeftCorner<3, 3>().trace();
    }
    return sum;
  };
  const auto bridged = without(body.samples(0.0, 3.0, 200.0), 1.0, 2.0);
  EXPECT_NEAR(rotation_variance(bridged, 20) / rotation_variance(bridged, 1), 1.0, 0.1);
  // Streaming, the far end is not known: the gap is as long as it has lasted so far.
  const auto held = body.samples(0.0, 1.0, 200.0);
  const double cut = rotation_variance(held, 20);
  EXPECT_GT(cut, 0.3 * rotation_variance(held, 1));
}

TEST(PreintegrateGap, MissingEndsAreHeld) {
  const SineMotion body;
  const auto samples = body.samples(1.0, 2.0, 200.0);
  for (const double t0 : {0.9, 1.95}) {
    const ImuMotion motion = integrate(samples, t0, t0 + 0.15);
    ASSERT_TRUE(motion.valid);
    EXPECT_TRUE(motion.degraded);
    EXPECT_LT(normalized_error(motion, body.truth(t0, t0 + 0.15)), 25.0);
  }
  // Streaming: the last sample may be a little older than the frame.
  EXPECT_FALSE(integrate(samples, 1.9, 2.003).degraded);
}

TEST(PreintegrateGap, IsInvalidWhereNothingIsNear) {
  const auto samples = SineMotion().samples(1.0, 2.0, 200.0);
  for (const double t0 : {5.0, -3.0}) {
    const ImuMotion motion = integrate(samples, t0, t0 + 0.1);
    EXPECT_FALSE(motion.valid);
    EXPECT_TRUE(motion.degraded);
    EXPECT_NEAR(motion.dt_s, 0.1, 1e-12);
    EXPECT_EQ(motion.dv, Eigen::Vector3d::Zero());
    EXPECT_GE(motion.covariance.diagonal().minCoeff(), 1e6);
  }
  EXPECT_FALSE(integrate({}, 0.0, 0.1).valid);
  EXPECT_FALSE(integrate(samples, -4000.0, 1.5).valid);  // a clock jump
}

TEST(PreintegrateGap, BrokenReadingsNeverComeThrough) {
  const SineMotion body;
  const double nan = std::numeric_limits<double>::quiet_NaN();
  const double infinity = std::numeric_limits<double>::infinity();
  for (const double wrong : {nan, infinity, -infinity, 1e30, 34.9, -160.0}) {
    for (const int count : {1, 2, 20}) {
      auto samples = body.samples(0.0, 2.0, 200.0);
      for (int i = 0; i < count; ++i) {
        samples[static_cast<std::size_t>(100 + i)].angular_velocity.y() = wrong;
        samples[static_cast<std::size_t>(100 + i)].linear_acceleration.x() = wrong;
      }
      const ImuMotion motion = integrate(samples, 0.45, 0.7);
      ASSERT_TRUE(motion.valid);
      EXPECT_TRUE(motion.covariance.allFinite());
      EXPECT_LT(normalized_error(motion, body.truth(0.45, 0.7)), 25.0) << wrong << " " << count;
      EXPECT_EQ(motion.degraded, std::isfinite(wrong) || count > 9) << wrong << " " << count;
    }
  }
}

TEST(PreintegrateGap, AllReadingsBrokenIsInvalid) {
  auto samples = SineMotion().samples(0.0, 1.0, 200.0);
  for (ImuSample& sample : samples) sample.linear_acceleration.setConstant(NAN);
  EXPECT_FALSE(integrate(samples, 0.3, 0.4).valid);
}

TEST(PreintegrateGap, RepeatedAndUnorderedStampsDoNotChangeTheResult) {
  const auto clean = SineMotion().samples(0.0, 1.0, 200.0);
  auto repeated = clean;
  repeated.insert(repeated.begin() + 70, clean[69]);
  repeated.insert(repeated.begin() + 75, clean[66]);
  expect_near(difference(integrate(repeated, 0.3, 0.4), integrate(clean, 0.3, 0.4)),
              Vector9d::Zero(), 1e-15);
}

TEST(PreintegrateGap, DerivativesHoldAcrossGapsAndHeldEnds) {
  auto samples = without(SineMotion().samples(0.0, 1.0, 200.0), 0.32, 0.45);
  const ImuNoise noise;
  for (const double t0 : {0.301, 0.9512}) {
    const auto run = [&](const Eigen::VectorXd& d) {
      const ImuBias bias{d.head<3>(), d.segment<3>(3)};
      return preintegrate(samples, stamp(t0), stamp(t0 + 0.2), bias, noise, d(6));
    };
    const ImuMotion motion = run(Eigen::VectorXd::Zero(7));
    const auto moved = [&](const Eigen::VectorXd& d) -> Eigen::VectorXd {
      return difference(run(d), motion);
    };
    Eigen::Matrix<double, 9, 7> J;
    J << motion.J_dR_bias, Eigen::Vector3d::Zero(), motion.J_dv_bias, Eigen::Vector3d::Zero(),
        motion.J_dp_bias, Eigen::Vector3d::Zero();
    J.col(6) = motion.J_time_offset;
    expect_near(J, numeric_jacobian(moved, Eigen::VectorXd::Zero(7)), 1e-6);
  }
}

}  // namespace
}  // namespace imslam::imu
