#include "slam/training/inertial_sensor.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <vector>

namespace imslam::training {
namespace {

constexpr int kSensors = 2000;

std::vector<simulation::ImuErrors> many_sensors(const InertialLogOptions& options = {}) {
  std::vector<simulation::ImuErrors> sensors;
  for (std::uint64_t seed = 0; seed < kSensors; ++seed) {
    sensors.push_back(draw_sensor(options, 1.0, Random(seed)));
  }
  return sensors;
}

double correlation(const std::vector<double>& x, const std::vector<double>& y) {
  double mean_x = 0.0;
  double mean_y = 0.0;
  for (std::size_t i = 0; i < x.size(); ++i) {
    mean_x += x[i] / static_cast<double>(x.size());
    mean_y += y[i] / static_cast<double>(x.size());
  }
  double xx = 0.0;
  double xy = 0.0;
  double yy = 0.0;
  for (std::size_t i = 0; i < x.size(); ++i) {
    xx += (x[i] - mean_x) * (x[i] - mean_x);
    xy += (x[i] - mean_x) * (y[i] - mean_y);
    yy += (y[i] - mean_y) * (y[i] - mean_y);
  }
  return xy / std::sqrt(xx * yy);
}

TEST(InertialSensor, BiasesCoverTheirRangeEvenlyAndDoNotFollowTheDatasheet) {
  std::vector<double> gyro;
  std::vector<double> accel;
  std::vector<double> stated;
  for (const simulation::ImuErrors& sensor : many_sensors()) {
    gyro.push_back(std::log(sensor.initial_bias.gyro.norm()));
    accel.push_back(std::log(sensor.initial_bias.accel.norm()));
    stated.push_back(std::log(sensor.data_sheet.gyro_noise_density));
  }
  EXPECT_LT(std::abs(correlation(gyro, stated)), 0.1);  // 4.5 sigma
  EXPECT_LT(std::abs(correlation(accel, stated)), 0.1);
  EXPECT_LT(std::abs(correlation(accel, gyro)), 0.1);
  std::sort(gyro.begin(), gyro.end());
  std::sort(accel.begin(), accel.end());
  EXPECT_GE(gyro.front(), std::log(1e-4) - 1e-9);
  EXPECT_LE(gyro.back(), std::log(0.15) + 1e-9);
  EXPECT_GE(accel.front(), std::log(1e-3) - 1e-9);
  EXPECT_LE(accel.back(), std::log(0.5) + 1e-9);
  for (const double share : {0.1, 0.25, 0.5, 0.75, 0.9}) {
    const auto i = static_cast<std::size_t>(share * kSensors);
    EXPECT_NEAR(gyro[i], std::log(1e-4) + share * std::log(0.15 / 1e-4), 0.35);
    EXPECT_NEAR(accel[i], std::log(1e-3) + share * std::log(0.5 / 1e-3), 0.35);
  }
}

TEST(InertialSensor, DatasheetsLieByUpToTwo) {
  double lowest = 1.0;
  double highest = 1.0;
  for (const simulation::ImuErrors& sensor : many_sensors()) {
    const double lie = sensor.data_sheet.accel_noise_density / sensor.noise.accel_noise_density;
    lowest = std::min(lowest, lie);
    highest = std::max(highest, lie);
    EXPECT_EQ(sensor.data_sheet.rate_hz, sensor.noise.rate_hz);
  }
  EXPECT_GT(lowest, 0.5 - 1e-9);
  EXPECT_LT(lowest, 0.51);
  EXPECT_LT(highest, 2.0 + 1e-9);
  EXPECT_GT(highest, 1.96);
}

TEST(InertialSensor, MostRatesAreOneOrTwoHundredHertz) {
  std::map<double, int> count;
  for (const simulation::ImuErrors& sensor : many_sensors()) ++count[sensor.noise.rate_hz];
  EXPECT_EQ(count.size(), 6U);
  for (const double rate : {50.0, 400.0, 500.0, 1000.0}) EXPECT_GT(count[rate], kSensors / 25);
  EXPECT_GT(count[100.0] + count[200.0], 6 * kSensors / 10);
}

TEST(InertialSensor, ScalesOfZeroLeaveNothingButADatasheet) {
  InertialLogOptions options;
  options.noise_scale = options.bias_scale = options.shape_scale = 0.0;
  options.g_sensitivity_scale = options.temperature_scale = options.vibration_scale = 0.0;
  const simulation::ImuErrors sensor = draw_sensor(options, 1.0, Random(1));
  EXPECT_EQ(sensor.noise.gyro_noise_density, 0.0);
  EXPECT_GT(sensor.data_sheet.gyro_noise_density, 0.0);
  EXPECT_TRUE(sensor.initial_bias.gyro.isZero(0.0));
  EXPECT_TRUE(sensor.gyro_shape.isIdentity(0.0));
  EXPECT_TRUE(sensor.g_sensitivity.isZero(0.0));
  EXPECT_TRUE(sensor.drift.gyro.isZero(0.0));
  EXPECT_EQ(sensor.vibration, 0.0);
}

TEST(InertialSensor, HalfTheMountingsAreAlongTheAxes) {
  Random random(3);
  int aligned = 0;
  Eigen::Vector3d mean_z = Eigen::Vector3d::Zero();
  for (int i = 0; i < kSensors; ++i) {
    const Eigen::Matrix3d R = draw_mounting(random).matrix();
    EXPECT_NEAR(R.determinant(), 1.0, 1e-12);
    const bool along = R.cwiseAbs().colwise().maxCoeff().minCoeff() > 0.98;
    aligned += along ? 1 : 0;
    mean_z += R.col(2) / kSensors;
  }
  EXPECT_NEAR(aligned, 0.5 * kSensors, 0.06 * kSensors);
  EXPECT_LT(mean_z.norm(), 0.06);  // no side is preferred
}

}  // namespace
}  // namespace imslam::training
