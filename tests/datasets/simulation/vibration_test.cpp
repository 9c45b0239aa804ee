#include "datasets/simulation/vibration.hpp"

#include <gtest/gtest.h>

#include <cmath>

namespace imslam::simulation {
namespace {

using Eigen::Vector3d;

constexpr double kRate_hz = 400.0;

/// Root mean square over axes and time [s] of the accelerometer's and the gyro's share.
std::pair<double, double> rms(Vibration& vibration, double from_s, double to_s) {
  double accel = 0.0;
  double gyro = 0.0;
  int count = 0;
  for (double t = from_s; t < to_s; t += 1.0 / kRate_hz) {
    const Vibration::Reading reading = vibration.next(t);
    accel += reading.accel.squaredNorm();
    gyro += reading.gyro.squaredNorm();
    count += 3;
  }
  return {std::sqrt(accel / count), std::sqrt(gyro / count)};
}

TEST(Vibration, IsAboutAsStrongAsAskedFor) {
  double power = 0.0;
  for (std::uint64_t seed = 0; seed < 40; ++seed) {
    Vibration vibration(2.0, kRate_hz, {{0.0, 1.0, 1.0}}, Random(seed));
    const auto [accel, gyro] = rms(vibration, 0.0, 20.0);
    EXPECT_GT(accel, 0.5);
    EXPECT_LT(accel, 6.0);
    EXPECT_GT(gyro, 0.002 * accel);
    EXPECT_LT(gyro, 0.4 * accel);
    power += accel * accel / 40.0;
  }
  EXPECT_GT(std::sqrt(power), 1.3);
  EXPECT_LT(std::sqrt(power), 3.0);
}

TEST(Vibration, IsSilentWhileNothingRuns) {
  Vibration vibration(2.0, kRate_hz,
                      {{3.0, 0.0, 0.0}, {4.0, 1.0, 1.0}, {9.0, 1.0, 1.0}, {10.0, 0.0, 0.0}},
                      Random(3));
  EXPECT_EQ(rms(vibration, 0.0, 3.0).first, 0.0);
  EXPECT_GT(rms(vibration, 3.1, 9.9).first, 0.3);
  EXPECT_EQ(rms(vibration, 10.0, 12.0).first, 0.0);
  Vibration never(2.0, kRate_hz, {}, Random(3));
  EXPECT_EQ(rms(never, 0.0, 5.0).first, 0.0);
}

TEST(Vibration, HasNoSlowPart) {
  // Shaking that stays in place: what is left over a second is far below the rms.
  for (std::uint64_t seed = 0; seed < 20; ++seed) {
    Vibration vibration(1.0, kRate_hz, {{0.0, 1.0, 1.0}}, Random(seed));
    const double whole = rms(vibration, 0.0, 5.0).first;
    double slow = 0.0;
    for (int second = 0; second < 20; ++second) {
      Vector3d mean = Vector3d::Zero();
      for (int i = 0; i < 400; ++i) {
        mean += vibration.next(5.0 + second + i / kRate_hz).accel / 400.0;
      }
      slow += mean.squaredNorm() / 60.0;
    }
    EXPECT_LT(std::sqrt(slow), 0.03 * whole) << seed;  // white noise would leave 0.05
  }
}

TEST(Vibration, DependsOnItsSeedOnly) {
  Vibration one(1.0, kRate_hz, {{0.0, 1.0, 1.0}}, Random(5));
  Vibration same(1.0, kRate_hz, {{0.0, 1.0, 1.0}}, Random(5));
  Vibration other(1.0, kRate_hz, {{0.0, 1.0, 1.0}}, Random(6));
  for (int i = 0; i < 100; ++i) {
    const double t = i / kRate_hz;
    const Vector3d accel = one.next(t).accel;
    EXPECT_EQ(accel, same.next(t).accel);
    EXPECT_NE(accel, other.next(t).accel);
  }
}

}  // namespace
}  // namespace imslam::simulation
