#include "imu_net/preintegration_gradient.hpp"

#include <gtest/gtest.h>

#include <algorithm>

#include "tests/imu_net/gradient_check.hpp"

namespace imslam::imu {
namespace {

using imslam::testing::numeric_jacobian;
using namespace testing;  // NOLINT(google-build-using-namespace): imu::testing, not gtest's

using Matrix9d = Eigen::Matrix<double, 9, 9>;
constexpr int kOutputs = 54;  ///< dR dv dp and the lower triangle of the covariance

/// Everything preintegrate() returns that has a gradient, in standard deviations.
Eigen::VectorXd outputs(const ImuMotion& motion, const ImuMotion& reference) {
  const Eigen::Matrix<double, 9, 1> sigma = reference.covariance.diagonal().cwiseSqrt();
  Eigen::VectorXd y(kOutputs);
  y.head<9>() = difference(motion, reference).cwiseQuotient(sigma);
  Eigen::Index at = 9;
  for (Eigen::Index i = 0; i < 9; ++i) {
    for (Eigen::Index j = 0; j <= i; ++j) {
      y(at++) = motion.covariance(i, j) / (sigma(i) * sigma(j));
    }
  }
  return y;
}

/// dL for L = outputs()(k).
MotionGradient output_gradient(const ImuMotion& reference, Eigen::Index k) {
  const Eigen::Matrix<double, 9, 1> sigma = reference.covariance.diagonal().cwiseSqrt();
  MotionGradient gradient;
  if (k < 9) {
    gradient.motion(k) = 1.0 / sigma(k);
    return gradient;
  }
  Eigen::Index at = 9;
  for (Eigen::Index i = 0; i < 9; ++i) {
    for (Eigen::Index j = 0; j <= i; ++j) {
      // Only half of the entry that is used: the symmetric part must count.
      if (at++ == k) gradient.covariance(i, j) = 1.0 / (sigma(i) * sigma(j));
    }
  }
  return gradient;
}

Eigen::MatrixXd analytic_jacobian(const Interval& interval, const Inputs& inputs) {
  PreintegrationRecord record;
  const ImuMotion motion = interval.run(&record);
  Eigen::MatrixXd J(kOutputs, inputs.size());
  for (Eigen::Index k = 0; k < kOutputs; ++k) {
    std::vector<SampleGradient> gradients(interval.samples.size());
    const ImuBias bias =
        add_preintegration_gradient(record, output_gradient(motion, k), gradients.data());
    J.row(k) = inputs.gather(gradients, bias).transpose();
  }
  return J;
}

Eigen::MatrixXd central_differences(const Interval& interval, const Inputs& inputs) {
  const ImuMotion reference = interval.run();
  const auto f = [&](const Eigen::VectorXd& d) -> Eigen::VectorXd {
    return outputs(inputs.moved(interval, d).run(), reference);
  };
  return numeric_jacobian(f, Eigen::VectorXd::Zero(inputs.size()), 1e-4);
}

/// Every output by every kind of input (rate, force, two variances, bias) on its own scale.
void expect_jacobians_agree(const Eigen::MatrixXd& actual,
                            const Eigen::MatrixXd& expected,
                            const std::string& name) {
  ASSERT_TRUE(actual.allFinite()) << name;
  for (Eigen::Index kind = 0; kind < 4; ++kind) {
    for (Eigen::Index row = 0; row < actual.rows(); ++row) {
      double scale = 1e-3, error = 0.0;
      for (Eigen::Index column = 0; column < actual.cols(); ++column) {
        if (column % 12 / 3 != kind) continue;
        scale = std::max(scale, std::abs(expected(row, column)));
        error = std::max(error, std::abs(actual(row, column) - expected(row, column)));
      }
      EXPECT_LT(error, 2e-6 * scale) << name << ", input " << kind << ", output " << row;
    }
  }
}

void expect_exact(const Interval& interval) {
  const Inputs inputs = inputs_around(interval);
  ASSERT_GE(inputs.count, 3U);
  const Eigen::MatrixXd expected = central_differences(interval, inputs);
  expect_jacobians_agree(analytic_jacobian(interval, inputs), expected, interval.name);
}

std::vector<ImuSample> swaying(double strength = 1.0) {
  return with_random_variances(SineMotion(strength).samples(0.0, 1.0, 200.0));
}

std::vector<ImuSample> constant(const Eigen::Vector3d& rate) {
  std::vector<ImuSample> samples;
  for (int i = 0; i <= 200; ++i) samples.push_back({stamp(0.005 * i), rate, {1.0, -2.0, 9.0}});
  return with_random_variances(samples);
}

TEST(PreintegrationGradient, MatchesCentralDifferencesBetweenAndAtTheStamps) {
  expect_exact({"ends between samples", swaying(), 0.3012, 0.3487});
  expect_exact({"ends at samples", swaying(), 0.3, 0.35});
  expect_exact({"begin at a sample", swaying(), 0.3, 0.3487});
  expect_exact({"inside one period", swaying(), 0.3011, 0.3038});
  expect_exact({"one period", swaying(), 0.3, 0.305});
  expect_exact({"across one sample", swaying(), 0.3012, 0.3058});
}

TEST(PreintegrationGradient, MatchesCentralDifferencesForAnyRate) {
  const Eigen::Vector3d axis = Eigen::Vector3d(0.5, -0.7, 0.2).normalized();
  for (const double rate : {0.0, 1e-9, 1e-3, 10.0, 30.0}) {
    Interval interval{"rate " + std::to_string(rate), constant(rate * axis), 0.3012, 0.3487};
    expect_exact(interval);
    interval.bias = {};
    expect_exact(interval);
  }
}

TEST(PreintegrationGradient, MatchesCentralDifferencesWithOffsetAndCutSteps) {
  Interval interval{"offset", swaying(2.0), 0.3012, 0.3487};
  interval.time_offset_s = -0.0123;
  expect_exact(interval);
  interval.name = "cut steps";
  interval.options.max_step_s = 0.002;
  expect_exact(interval);
}

TEST(PreintegrationGradient, MatchesCentralDifferencesWithUnevenStamps) {
  Interval interval{"jitter", swaying(), 0.3012, 0.3487};
  Random random(5);
  for (ImuSample& sample : interval.samples) {
    sample.time_ns += to_nanoseconds(2e-4 * random.uniform(-1.0, 1.0));
  }
  expect_exact(interval);
}

TEST(PreintegrationGradient, IsExactInAGapButForTheSpread) {
  Interval interval{"gap", swaying(), 0.3012, 0.3687};
  interval.samples.erase(interval.samples.begin() + 63, interval.samples.begin() + 68);
  interval.samples[72].angular_velocity.x() = NAN;
  const Inputs inputs = inputs_around(interval);
  Eigen::MatrixXd expected = central_differences(interval, inputs);
  Eigen::MatrixXd actual = analytic_jacobian(interval, inputs);
  for (Eigen::Index column = 0; column < actual.cols(); ++column) {
    const bool variance = column < actual.cols() - 6 && column % 12 >= 6;
    const bool broken = expected.col(column).array().isNaN().any();
    if (broken) {
      EXPECT_TRUE(actual.col(column).isZero(0.0));
      expected.col(column).setZero();
    }
    if (!variance) actual.col(column).tail(45).setZero();
    if (!variance) expected.col(column).tail(45).setZero();
  }
  expect_jacobians_agree(actual, expected, interval.name);
}

TEST(PreintegrationGradient, ReachesTheSampleThatIsHeldAtAnEnd) {
  const Interval late{"held at the end", swaying(), 0.97, 1.004};
  const Interval early{"held at the beginning", swaying(), -0.004, 0.0287};
  const Interval alone{"one sample", {swaying()[60]}, 0.296, 0.303};
  for (const Interval& interval : {late, early}) {
    ASSERT_FALSE(interval.run().degraded);
    expect_exact(interval);
  }
  const Inputs inputs{0, 1};
  expect_jacobians_agree(analytic_jacobian(alone, inputs), central_differences(alone, inputs),
                         alone.name);
}

TEST(PreintegrationGradient, OfALikelihoodMatchesCentralDifferences) {
  const Interval interval{"likelihood", swaying(), 0.3012, 0.4487};
  ImuMotion target = interval.run();
  target.dR = target.dR * lie::SO3d::exp({0.02, -0.01, 0.03});
  target.dv += Eigen::Vector3d(0.1, -0.2, 0.05);
  target.dp += Eigen::Vector3d(-0.01, 0.02, 0.01);
  const Inputs inputs = inputs_around(interval);
  const auto loss = [&](const Eigen::VectorXd& d) -> Eigen::VectorXd {
    const double value = negative_log_likelihood(inputs.moved(interval, d).run(), target);
    return Eigen::VectorXd::Constant(1, value);
  };
  PreintegrationRecord record;
  const ImuMotion motion = interval.run(&record);
  std::vector<SampleGradient> gradients(interval.samples.size());
  const ImuBias bias =
      add_preintegration_gradient(record, likelihood_gradient(motion, target), gradients.data());
  const Eigen::VectorXd zero = Eigen::VectorXd::Zero(inputs.size());
  expect_jacobians_agree(inputs.gather(gradients, bias).transpose(),
                         numeric_jacobian(loss, zero, 1e-5), interval.name);
}

TEST(PreintegrationGradient, AddsUpOverIntervalsThatShareSamples) {
  const Interval first{"chain", swaying(), 0.3012, 0.3337};
  Interval second = first;
  second.t0 = first.t1;
  second.t1 = 0.3698;
  Interval whole = first;
  whole.t1 = second.t1;
  const Inputs inputs = inputs_around(whole);
  const ImuMotion target0 = SineMotion().truth(first.t0, first.t1);
  const ImuMotion target1 = SineMotion().truth(second.t0, second.t1);
  const auto loss = [&](const Eigen::VectorXd& d) -> Eigen::VectorXd {
    const double value = negative_log_likelihood(inputs.moved(first, d).run(), target0) +
                         negative_log_likelihood(inputs.moved(second, d).run(), target1);
    return Eigen::VectorXd::Constant(1, value);
  };
  std::vector<SampleGradient> gradients(first.samples.size());
  PreintegrationRecord record;  // the same for both
  const ImuMotion motion0 = first.run(&record);
  ImuBias bias =
      add_preintegration_gradient(record, likelihood_gradient(motion0, target0), gradients.data());
  const ImuMotion motion1 = second.run(&record);
  const ImuBias more =
      add_preintegration_gradient(record, likelihood_gradient(motion1, target1), gradients.data());
  bias.gyro += more.gyro;
  bias.accel += more.accel;
  const Eigen::VectorXd zero = Eigen::VectorXd::Zero(inputs.size());
  expect_jacobians_agree(inputs.gather(gradients, bias).transpose(),
                         numeric_jacobian(loss, zero, 1e-5), "chain");
}

TEST(PreintegrationGradient, IsTheSameForAPieceOfTheLog) {
  const Interval interval{"piece", swaying(), 0.3012, 0.3487};
  const ImuRange all = interval.samples;
  const ImuRange piece = all.around(stamp(interval.t0), stamp(interval.t1));
  PreintegrationRecord record;
  const MotionGradient dL = output_gradient(interval.run(&record), 30);
  std::vector<SampleGradient> of_log(all.size());
  add_preintegration_gradient(record, dL, of_log.data());
  preintegrate(piece, stamp(interval.t0), stamp(interval.t1), interval.bias, Interval::noise(), 0.0,
               {}, &record);
  std::vector<SampleGradient> of_piece(piece.size());
  add_preintegration_gradient(record, dL, of_piece.data());
  for (std::size_t i = 0; i < piece.size(); ++i) {
    const auto at = static_cast<std::size_t>(piece.begin() - all.begin()) + i;
    EXPECT_EQ(of_piece[i].angular_velocity, of_log[at].angular_velocity);
    EXPECT_EQ(of_piece[i].accel_variance, of_log[at].accel_variance);
  }
}

TEST(PreintegrationGradient, OfNothingKnownIsZero) {
  Interval interval{"lost", swaying(), 0.3, 0.9};
  interval.options.max_bridge_s = 0.1;
  interval.samples.erase(interval.samples.begin() + 80, interval.samples.begin() + 120);
  PreintegrationRecord record;
  const ImuMotion motion = interval.run(&record);
  ASSERT_FALSE(motion.valid);
  MotionGradient dL;
  dL.motion.setOnes();
  dL.covariance.setOnes();
  std::vector<SampleGradient> gradients(interval.samples.size());
  EXPECT_EQ(add_preintegration_gradient(record, dL, gradients.data()).gyro,
            Eigen::Vector3d::Zero());
  for (const SampleGradient& g : gradients) EXPECT_TRUE(g.angular_velocity.isZero(0.0));
}

}  // namespace
}  // namespace imslam::imu
