#include "imu_net/preintegration.hpp"

#include <gtest/gtest.h>

#include "slam/base/config.hpp"
#include "slam/base/error.hpp"
#include "tests/imu_net/synthetic_motion.hpp"
#include "tests/support/numeric_jacobian.hpp"

namespace imslam::imu {
namespace {

using imslam::testing::expect_near;
using imslam::testing::numeric_jacobian;
using testing::disturb;
using testing::kGravity;
using testing::SineMotion;
using testing::stamp;
using Vector9d = Eigen::Matrix<double, 9, 1>;

const ImuBias kBias{{0.01, -0.02, 0.03}, {0.1, 0.05, -0.08}};

ImuMotion integrate(const std::vector<ImuSample>& samples,
                    double t0,
                    double t1,
                    const ImuBias& bias = {},
                    double time_offset_s = 0.0) {
  return preintegrate(samples, stamp(t0), stamp(t1), bias, ImuNoise{}, time_offset_s);
}

std::vector<ImuSample> constant_signal(const Eigen::Vector3d& w, const Eigen::Vector3d& a) {
  std::vector<ImuSample> samples;
  for (int i = 0; i <= 200; ++i) samples.push_back({stamp(0.005 * i), w, a});
  return samples;
}

TEST(Preintegrate, ConstantForceWithoutRotationIsExact) {
  const Eigen::Vector3d a(1.0, -2.0, 9.0);
  const ImuMotion motion = integrate(constant_signal({0, 0, 0}, a), 0.0131, 0.9173);
  const double dt = 0.9173 - 0.0131;
  ASSERT_TRUE(motion.valid);
  EXPECT_FALSE(motion.degraded);
  EXPECT_NEAR(motion.dt_s, dt, 1e-12);
  expect_near(motion.dR.log(), Eigen::Vector3d::Zero(), 1e-15);
  expect_near(motion.dv, dt * a, 1e-12);
  expect_near(motion.dp, 0.5 * dt * dt * a, 1e-12);
}

TEST(Preintegrate, ConstantRateAndForceMatchTheClosedForm) {
  const Eigen::Vector3d w(0.8, -1.5, 0.4);
  const Eigen::Vector3d a(1.0, -2.0, 9.0);
  const double dt = 0.75;
  const ImuMotion motion = integrate(constant_signal(w, a), 0.1, 0.1 + dt);
  expect_near(motion.dR.log(), dt * w, 1e-12);
  expect_near(motion.dv, dt * lie::SO3d::left_jacobian(dt * w) * a, 2e-5);
}

TEST(Preintegrate, ErrorShrinksWithTheSquareOfTheRate) {
  const SineMotion body;
  const ImuMotion truth = body.truth(0.2, 1.2);
  Vector9d coarse;
  for (const double rate_hz : {50.0, 100.0, 200.0, 400.0}) {
    ImuNoise noise;
    noise.rate_hz = rate_hz;
    const ImuMotion motion =
        preintegrate(body.samples(0.0, 2.0, rate_hz), stamp(0.2), stamp(1.2), ImuBias{}, noise);
    const Vector9d error = difference(motion, truth);
    if (rate_hz > 50.0) {
      EXPECT_NEAR(coarse.head<3>().norm() / error.head<3>().norm(), 4.0, 0.3) << rate_hz;
      EXPECT_NEAR(coarse.segment<3>(3).norm() / error.segment<3>(3).norm(), 4.0, 0.3) << rate_hz;
      EXPECT_NEAR(coarse.tail<3>().norm() / error.tail<3>().norm(), 4.0, 0.3) << rate_hz;
    }
    coarse = error;
  }
  EXPECT_LT(coarse.norm(), 1e-4);
}

TEST(Preintegrate, EndsBetweenSamplesAreInterpolated) {
  const SineMotion body;
  const auto samples = body.samples(0.0, 2.0, 200.0);
  for (const double t0 : {0.2, 0.2013, 0.2049}) {
    for (const double t1 : {0.206, 0.25, 0.2987}) {
      const Vector9d error = difference(integrate(samples, t0, t1), body.truth(t0, t1));
      EXPECT_LT(error.norm(), 1e-5) << t0 << " " << t1;
    }
  }
}

TEST(Preintegrate, PiecesMultiplyToTheWhole) {
  const SineMotion body;
  const auto samples = body.samples(0.0, 2.0, 200.0);
  lie::NavState state = body.state(0.1);
  for (int i = 0; i < 10; ++i) {
    state = predict(state, integrate(samples, 0.1 + 0.1 * i, 0.2 + 0.1 * i), kGravity);
  }
  const lie::NavState whole = predict(body.state(0.1), integrate(samples, 0.1, 1.1), kGravity);
  expect_near(state.minus(whole), Vector9d::Zero(), 1e-12);
  expect_near(state.minus(body.state(1.1)), Vector9d::Zero(), 1e-3);
}

TEST(Preintegrate, TimeOffsetMovesBothEnds) {
  const auto samples = SineMotion().samples(0.0, 2.0, 200.0);
  const ImuMotion moved = integrate(samples, 0.3, 0.4, {}, 0.0123);
  const ImuMotion direct = integrate(samples, 0.3123, 0.4123);
  expect_near(difference(moved, direct), Vector9d::Zero(), 1e-9);
  EXPECT_EQ(moved.time_offset_s, 0.0123);
}

TEST(Preintegrate, BiasJacobiansMatchCentralDifferences) {
  const auto samples = SineMotion().samples(0.0, 2.0, 200.0);
  for (const double t1 : {0.303, 0.35, 0.8}) {
    const ImuMotion motion = integrate(samples, 0.3012, t1, kBias);
    const auto moved = [&](const Eigen::VectorXd& d) -> Eigen::VectorXd {
      const ImuBias bias{kBias.gyro + d.head<3>(), kBias.accel + d.tail<3>()};
      return difference(integrate(samples, 0.3012, t1, bias), motion);
    };
    const Eigen::MatrixXd J = numeric_jacobian(moved, Eigen::VectorXd::Zero(6));
    expect_near(motion.J_dR_bias, J.topRows(3), 1e-6);
    expect_near(motion.J_dv_bias, J.middleRows(3, 3), 1e-6);
    expect_near(motion.J_dp_bias, J.bottomRows(3), 1e-6);
  }
}

TEST(Preintegrate, TimeOffsetJacobianMatchesCentralDifferences) {
  const auto samples = SineMotion().samples(0.0, 2.0, 200.0);
  for (const double t1 : {0.303, 0.3512, 0.8012}) {  // one segment, a frame, long
    const ImuMotion motion = integrate(samples, 0.3012, t1, kBias, 0.0002);
    const auto moved = [&](const Eigen::VectorXd& d) -> Eigen::VectorXd {
      return difference(integrate(samples, 0.3012, t1, kBias, 0.0002 + d(0)), motion);
    };
    expect_near(motion.J_time_offset, numeric_jacobian(moved, Eigen::VectorXd::Zero(1)), 1e-6);
  }
}

// J_dR = w1 - dR^T w0,  J_dv = dR a1 - a0 - w0 x dv,  J_dp = dv - a0 dt - w0 x dp.
TEST(Preintegrate, TimeOffsetJacobianTendsToTheClosedForm) {
  const SineMotion body;
  const ImuMotion motion = integrate(body.samples(0.0, 1.0, 1000.0), 0.30051, 0.40052);
  const ImuSample s0 = body.sample(0.30051);
  const ImuSample s1 = body.sample(0.40052);
  Vector9d closed;
  closed << s1.angular_velocity - (motion.dR.inverse() * s0.angular_velocity),
      motion.dR * s1.linear_acceleration - s0.linear_acceleration -
          s0.angular_velocity.cross(motion.dv),
      motion.dv - motion.dt_s * s0.linear_acceleration - s0.angular_velocity.cross(motion.dp);
  expect_near(motion.J_time_offset, closed, 1e-3);
}

TEST(CorrectForBias, AgreesWithIntegratingAgain) {
  const auto samples = SineMotion().samples(0.0, 2.0, 200.0);
  const ImuMotion motion = integrate(samples, 0.3, 0.4);
  const ImuBias nearby{0.1 * kBias.gyro, 0.1 * kBias.accel};
  const ImuMotion corrected = correct_for_bias(motion, nearby);
  expect_near(difference(corrected, integrate(samples, 0.3, 0.4, nearby)), Vector9d::Zero(), 1e-6);
  EXPECT_EQ(corrected.bias.gyro, nearby.gyro);
  EXPECT_GT(difference(corrected, motion).norm(), 1e-4);
}

TEST(CorrectForTimeOffset, AgreesWithIntegratingAgain) {
  const auto samples = SineMotion().samples(0.0, 2.0, 200.0);
  const ImuMotion motion = integrate(samples, 0.3, 0.4);
  const ImuMotion corrected = correct_for_time_offset(motion, 1e-3);
  const ImuMotion again = integrate(samples, 0.3, 0.4, {}, 1e-3);
  expect_near(difference(corrected, again), Vector9d::Zero(), 2e-5);
  EXPECT_GT(difference(corrected, motion).norm(), 1e-4);
}

TEST(Predict, InvertsMotionBetween) {
  const SineMotion body;
  const lie::NavState predicted = predict(body.state(0.2), body.truth(0.2, 0.9), kGravity);
  expect_near(predicted.minus(body.state(0.9)), Vector9d::Zero(), 1e-12);
}

// Average squared error in units of the covariance: 9 degrees of freedom, 400 runs, the chi-square
// 99.9 % band of the average is 9 +- 3.3 sqrt(18 / 400).
TEST(Preintegrate, CovarianceMatchesMonteCarlo) {
  constexpr int kRuns = 400;
  const SineMotion body;
  const auto clean = body.samples(0.0, 1.0, 200.0);
  const ImuMotion motion = integrate(clean, 0.2, 0.7);
  Random random(11);
  Eigen::Matrix<double, 9, 9> scatter = Eigen::Matrix<double, 9, 9>::Zero();
  for (int run = 0; run < kRuns; ++run) {
    auto noisy = clean;
    disturb(noisy, {}, ImuNoise{}, random);
    const Vector9d error = difference(integrate(noisy, 0.2, 0.7), motion);
    scatter += error * error.transpose() / kRuns;
  }
  EXPECT_NEAR((motion.covariance.inverse() * scatter).trace(), 9.0, 0.75);
  const Vector9d ratio = scatter.diagonal().cwiseQuotient(motion.covariance.diagonal());
  EXPECT_GT(ratio.minCoeff(), 0.78);
  EXPECT_LT(ratio.maxCoeff(), 1.25);
}

TEST(Preintegrate, CovarianceIsPositiveDefiniteEvenForOneStep) {
  const auto samples = SineMotion().samples(0.0, 1.0, 200.0);
  const ImuMotion motion = integrate(samples, 0.301, 0.304);
  const Eigen::LLT<Eigen::MatrixXd> factor(motion.covariance);
  EXPECT_EQ(factor.info(), Eigen::Success);
  EXPECT_EQ(motion.covariance, motion.covariance.transpose());
}

TEST(Preintegrate, RejectsAnEmptyIntervalAndAWildOffset) {
  const auto samples = SineMotion().samples(0.0, 1.0, 200.0);
  EXPECT_THROW(integrate(samples, 0.3, 0.3), ContractError);
  EXPECT_THROW(integrate(samples, 0.3, 0.4, {}, NAN), ContractError);
  EXPECT_THROW(integrate(samples, 0.3, 0.4, {}, 1e300), ContractError);
}

TEST(PreintegrationOptions, ReadFromTheConfigAndNameTheBrokenKey) {
  PreintegrationOptions options;
  EXPECT_NO_THROW(options.validate());
  Config config;
  config.section("imu", options);
  config.set("imu.max_gap_s=-1", "test");
  try {
    options.validate();
    FAIL() << "expected InputError";
  } catch (const InputError& error) {
    EXPECT_NE(std::string(error.what()).find("max_gap_s"), std::string::npos);
    EXPECT_EQ(error.code(), ExitCode::kUsage);
  }
}

}  // namespace
}  // namespace imslam::imu
