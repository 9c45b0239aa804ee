#include "imu_net/correction_loss.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "slam/nn/ops/layout.hpp"
#include "tests/imu_net/synthetic_motion.hpp"
#include "tests/support/numeric_jacobian.hpp"

namespace imslam::imu {
namespace {

using imslam::testing::expect_near;
using imslam::testing::numeric_jacobian;
using nn::Index;
using nn::Tensor;
using nn::Var;

constexpr Index kBins = 20;
constexpr Index kCount = 6 * kBins;

/// Two seconds of a swaying sensor with windows of several lengths.
struct Fixture {
  Fixture() {
    const testing::SineMotion motion;
    samples = motion.samples(0.0, 2.3, 100.0);
    Random random(2);
    noise.rate_hz = 100.0;
    testing::disturb(samples, {{0.01, -0.02, 0.005}, {0.05, 0.1, -0.1}}, noise, random);
    task.samples = &samples;
    task.noise = noise;
    for (Index k = 0; k < kBins; ++k) {
      task.frame_times.push_back(testing::stamp(0.1 * static_cast<double>(k + 1)));
    }
    for (const auto& [t0, t1] : {std::pair(0.25, 0.45), std::pair(0.9, 2.1), std::pair(1.5, 2.0),
                                 std::pair(0.05, 1.0)}) {  // the last begins before the first frame
      ImuMotion window = motion.truth(t0, t1);
      window.time0_ns = testing::stamp(t0);
      window.time1_ns = testing::stamp(t1);
      window.covariance *= 1e-8;
      task.windows.push_back(window);
    }
  }

  /// The loss for numbers of the answer [offset, noise, edge noise, log sigma], and their gradient.
  double loss(const Eigen::VectorXd& numbers, Eigen::VectorXd* gradient = nullptr) const {
    nn::Tape<double> tape;
    const auto input = [&](Index start) {
      Tensor<double> values({3, kBins, 2});
      for (Index i = 0; i < kCount; ++i) values[i] = numbers[start + i];
      return tape.input(values);
    };
    ImuAnswer answer;
    answer.offset = input(0);
    answer.noise = input(kCount);
    answer.edge_noise = input(2 * kCount);
    answer.log_sigma = input(3 * kCount);
    const Var y = correction_loss(tape, answer, task);
    if (gradient != nullptr) {
      tape.backward(y);
      gradient->resize(4 * kCount);
      Index place = 0;
      for (const Var v : {answer.offset, answer.noise, answer.edge_noise, answer.log_sigma}) {
        for (Index i = 0; i < kCount; ++i) (*gradient)[place++] = tape.gradient_data(v)[i];
      }
    }
    return tape.number(y);
  }

  std::vector<ImuSample> samples;
  ImuNoise noise;
  CorrectionTask task;
};

Eigen::VectorXd some_answer(double log_sigma_shift = 0.0) {
  Random random(7);
  Eigen::VectorXd numbers(4 * kCount);
  for (Index i = 0; i < kCount; ++i) {
    numbers[i] = 0.02 * random.normal();
    numbers[kCount + i] = 0.5 + 0.5 * random.normal();
    numbers[2 * kCount + i] = 0.5 + 0.5 * random.normal();
    numbers[3 * kCount + i] = (i % 2 == 0 ? -5.0 : -3.0) + log_sigma_shift + 0.3 * random.normal();
  }
  return numbers;
}

Eigen::VectorXd numeric_gradient(const Fixture& fixture, const Eigen::VectorXd& numbers) {
  const auto f = [&](const Eigen::VectorXd& x) {
    return Eigen::VectorXd::Constant(1, fixture.loss(x)).eval();
  };
  return numeric_jacobian(f, numbers, 1e-5).transpose();
}

Eigen::VectorXd gradient_of(const Fixture& fixture, const Eigen::VectorXd& numbers) {
  Eigen::VectorXd gradient;
  fixture.loss(numbers, &gradient);
  return gradient;
}

TEST(CorrectionLoss, GradientOfNoiseAndSigmaMatchesDifferences) {
  Fixture fixture;
  const Eigen::VectorXd numbers = some_answer();
  for (const double jump : {0.0, 3.0}) {  // 3 m: the robust part rules
    for (ImuMotion& window : fixture.task.windows) window.dp.x() += jump;
    expect_near(gradient_of(fixture, numbers).tail(3 * kCount),
                numeric_gradient(fixture, numbers).tail(3 * kCount), 1e-6);
  }
}

// The bias Jacobian counts as constant: it plays no part where the sigmas are tiny.
TEST(CorrectionLoss, GradientOfOffsetsMatchesDifferences) {
  const Fixture fixture;
  const Eigen::VectorXd numbers = some_answer(-12.0);
  expect_near(gradient_of(fixture, numbers).head(kCount),
              numeric_gradient(fixture, numbers).head(kCount), 1e-6);
}

TEST(CorrectionLoss, EachNoiseIsTaughtByWindowsOfItsLength) {
  Fixture fixture;
  const auto windows = fixture.task.windows;
  fixture.task.windows = {windows[1]};  // 1.2 s
  const Eigen::VectorXd lengthy = gradient_of(fixture, some_answer());
  EXPECT_GT(lengthy.segment(kCount, kCount).norm(), 0.0);
  EXPECT_EQ(lengthy.segment(2 * kCount, kCount).norm(), 0.0);
  fixture.task.windows = {windows[0]};  // 0.2 s
  const Eigen::VectorXd brief = gradient_of(fixture, some_answer());
  EXPECT_EQ(brief.segment(kCount, kCount).norm(), 0.0);
  EXPECT_GT(brief.segment(2 * kCount, kCount).norm(), 0.0);
}

TEST(CorrectionLoss, IsLeastWhereTheSigmasAreRight) {
  Fixture fixture;
  fixture.task.windows.pop_back();
  const auto at = [&](double shift) {
    Eigen::VectorXd numbers = Eigen::VectorXd::Zero(4 * kCount);
    numbers.segment(kCount, 2 * kCount).setConstant(-4.0);
    for (Index i = 0; i < kCount; ++i) {
      numbers[3 * kCount + i] = std::log(i % 2 == 0 ? 0.013 : 0.087) + shift;
    }
    return fixture.loss(numbers);
  };
  EXPECT_LT(at(0.0), at(1.5));
  EXPECT_LT(at(0.0), at(-1.5));
}

TEST(CorrectionLoss, TheRightOffsetMakesItSmaller) {
  const Fixture fixture;
  const Eigen::VectorXd nothing = [] {
    Eigen::VectorXd numbers = Eigen::VectorXd::Zero(4 * kCount);
    numbers.tail(kCount).setConstant(-4.0);
    return numbers;
  }();
  Eigen::VectorXd right = nothing;
  const double truth[3][2] = {{0.01, 0.05}, {-0.02, 0.1}, {0.005, -0.1}};
  for (int axis = 0; axis < 3; ++axis) {
    for (Index bin = 0; bin < kBins; ++bin) {
      for (int sensor = 0; sensor < 2; ++sensor) {
        right[2 * (axis * kBins + bin) + sensor] = truth[axis][sensor];
      }
    }
  }
  EXPECT_LT(fixture.loss(right), fixture.loss(nothing) - 0.05);
}

TEST(CorrectionLoss, WithoutAWindowItIsZero) {
  Fixture fixture;
  fixture.task.windows.clear();
  Eigen::VectorXd gradient;
  EXPECT_EQ(fixture.loss(some_answer(), &gradient), 0.0);
  EXPECT_EQ(gradient.norm(), 0.0);
}

}  // namespace
}  // namespace imslam::imu
