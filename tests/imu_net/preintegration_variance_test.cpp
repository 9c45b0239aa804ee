#include <gtest/gtest.h>

#include "imu_net/preintegration.hpp"
#include "tests/imu_net/synthetic_motion.hpp"
#include "tests/support/numeric_jacobian.hpp"

namespace imslam::imu {
namespace {

using imslam::testing::expect_near;
using testing::SineMotion;
using testing::stamp;
using Matrix9d = Eigen::Matrix<double, 9, 9>;

Matrix9d covariance(const std::vector<ImuSample>& samples, double t0, double t1) {
  return preintegrate(samples, stamp(t0), stamp(t1), ImuBias{}, ImuNoise{}).covariance;
}

std::vector<ImuSample> with_variance(std::vector<ImuSample> samples,
                                     const Eigen::Vector3d& gyro,
                                     const Eigen::Vector3d& accel) {
  for (ImuSample& sample : samples) {
    sample.gyro_variance = gyro;
    sample.accel_variance = accel;
  }
  return samples;
}

/// In units of the expected standard deviations.
void expect_same_covariance(const Matrix9d& actual, const Matrix9d& expected, double tolerance) {
  const Eigen::Matrix<double, 9, 1> scale = expected.diagonal().cwiseSqrt().cwiseInverse();
  const Matrix9d difference = scale.asDiagonal() * (actual - expected) * scale.asDiagonal();
  EXPECT_LT(difference.cwiseAbs().maxCoeff(), tolerance) << difference;
}

TEST(PreintegrateVariance, EqualAxesActLikeALouderDatasheet) {
  const auto clean = SineMotion().samples(0.0, 2.0, 200.0);
  const ImuNoise noise;
  ImuNoise louder = noise;
  louder.gyro_noise_density *= 2.0;
  louder.accel_noise_density *= 3.0;
  const double gyro = 3.0 * noise.gyro_noise_density * noise.gyro_noise_density;
  const double accel = 8.0 * noise.accel_noise_density * noise.accel_noise_density;
  const auto noisy =
      with_variance(clean, Eigen::Vector3d::Constant(gyro), Eigen::Vector3d::Constant(accel));
  for (const double t1 : {0.302, 0.35, 1.3}) {
    const ImuMotion expected = preintegrate(clean, stamp(0.3), stamp(t1), ImuBias{}, louder);
    expect_same_covariance(covariance(noisy, 0.3, t1), expected.covariance, 1e-12);
  }
}

// d Sigma_v / dt = R diag(q) R^T and d Sigma_p = (t1 - t)^2 R diag(q) R^T dt, summed finely.
TEST(PreintegrateVariance, EachAxisTurnsWithTheBody) {
  const Eigen::Vector3d w(0.5, 9.0, -4.0);
  const Eigen::Vector3d q(4e-3, 1e-6, 3e-4);
  std::vector<ImuSample> samples;
  for (int i = 0; i <= 400; ++i) samples.push_back({stamp(0.0025 * i), w, {0, 0, 0}});
  const auto noisy = with_variance(samples, {0, 0, 0}, q);
  const double t1 = 0.4;
  const Matrix9d added = covariance(noisy, 0.0, t1) - covariance(samples, 0.0, t1);
  constexpr int kPieces = 4000;
  Eigen::Matrix3d expected_v = Eigen::Matrix3d::Zero();
  Eigen::Matrix3d expected_p = Eigen::Matrix3d::Zero();
  for (int i = 0; i < kPieces; ++i) {
    const double t = (i + 0.5) * t1 / kPieces;
    const Eigen::Matrix3d R = lie::SO3d::exp(t * w).matrix();
    const Eigen::Matrix3d rate = R * q.asDiagonal() * R.transpose();
    expected_v += rate * t1 / kPieces;
    expected_p += (t1 - t) * (t1 - t) * rate * t1 / kPieces;
  }
  expect_near(1e3 * added.block<3, 3>(3, 3), 1e3 * expected_v, 1e-4);
  expect_near(1e5 * added.bottomRightCorner<3, 3>(), 1e5 * expected_p, 1e-3);
}

TEST(PreintegrateVariance, OneStepHasTheClosedForm) {
  auto samples = with_variance(SineMotion(0.0).samples(0.0, 1.0, 200.0), {0, 0, 0}, {0, 0, 0});
  samples[60].accel_variance = {8e-3, 0, 0};  // at 0.3 s; the next one has none
  const double h = 0.005;
  const Matrix9d added = covariance(samples, 0.3, 0.3 + h) -
                         covariance(SineMotion(0.0).samples(0.0, 1.0, 200.0), 0.3, 0.3 + h);
  EXPECT_NEAR(added(3, 3), 4e-3 * h, 1e-12);
  EXPECT_NEAR(added(3, 6), 4e-3 * h * h / 2, 1e-14);
  EXPECT_NEAR(added(6, 6), 4e-3 * h * h * h / 3, 1e-17);
  EXPECT_NEAR(added(4, 4), 0.0, 1e-18);
}

TEST(PreintegrateVariance, ReadingsWithoutASensibleVarianceAreDropped) {
  const auto clean = SineMotion().samples(0.0, 1.0, 200.0);
  for (const double wrong : {-1e-9, std::nan(""), HUGE_VAL}) {
    auto samples = clean;
    samples[70].gyro_variance.y() = wrong;
    auto without = clean;
    without.erase(without.begin() + 70);
    EXPECT_EQ(covariance(samples, 0.3, 0.4), covariance(without, 0.3, 0.4)) << wrong;
  }
}

}  // namespace
}  // namespace imslam::imu
