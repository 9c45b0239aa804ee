#include "slam/training/inertial_log_generator.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <set>
#include <string>

#include "imu_net/preintegration.hpp"
#include "slam/base/config.hpp"
#include "slam/base/error.hpp"
#include "slam/base/parallel.hpp"

namespace imslam::training {
namespace {

using Eigen::Vector3d;

InertialLogOptions short_logs() {
  InertialLogOptions options;
  options.min_duration_s = 20.0;
  options.max_duration_s = 30.0;
  options.rate_hz = 100.0;
  return options;
}

InertialLogOptions without_errors(double rate_hz) {
  InertialLogOptions options = short_logs();
  options.rate_hz = rate_hz;
  options.noise_scale = options.bias_scale = options.shape_scale = 0.0;
  options.g_sensitivity_scale = options.temperature_scale = options.vibration_scale = 0.0;
  options.quantised_share = options.jitter_share = options.gap_share = 0.0;
  return options;
}

void expect_equal(const InertialLog& a, const InertialLog& b) {
  EXPECT_EQ(a.name, b.name);
  ASSERT_EQ(a.samples.size(), b.samples.size());
  for (std::size_t i = 0; i < a.samples.size(); ++i) {
    ASSERT_EQ(a.samples[i].time_ns, b.samples[i].time_ns);
    ASSERT_EQ(a.samples[i].angular_velocity, b.samples[i].angular_velocity);
    ASSERT_EQ(a.samples[i].linear_acceleration, b.samples[i].linear_acceleration);
  }
  ASSERT_EQ(a.truth.size(), b.truth.size());
  for (std::size_t i = 0; i < a.truth.size(); ++i) {
    ASSERT_EQ(a.truth[i].nav.T_world_body.matrix(), b.truth[i].nav.T_world_body.matrix());
    ASSERT_EQ(a.truth[i].nav.v_world, b.truth[i].nav.v_world);
  }
  EXPECT_EQ(a.noise.gyro_noise_density, b.noise.gyro_noise_density);
}

TEST(InertialLogGenerator, ALogDependsOnOptionsAndIndexOnly) {
  const InertialLogGenerator generator(short_logs());
  std::vector<InertialLog> forwards;
  for (std::uint64_t i = 0; i < 8; ++i) forwards.push_back(generator.make(i));
  std::vector<InertialLog> parallel(8);
  const InertialLogGenerator other(short_logs());
  parallel_for(8, [&](std::size_t i) { parallel[i] = other.make(i); });
  for (std::size_t i = 8; i-- > 0;) {
    expect_equal(forwards[i], generator.make(i));
    expect_equal(forwards[i], parallel[i]);
  }
  EXPECT_NE(forwards[0].truth.back().nav.v_world, forwards[1].truth.back().nav.v_world);
  InertialLogOptions reseeded = short_logs();
  reseeded.seed = 2;
  EXPECT_NE(InertialLogGenerator(reseeded).make(0).samples.front().linear_acceleration,
            forwards[0].samples.front().linear_acceleration);
}

TEST(InertialLogGenerator, ReadingsOfAnErrorlessSensorIntegrateToTheTruth) {
  const InertialLogGenerator generator(without_errors(500.0));
  std::set<std::string> families;
  for (std::uint64_t index = 0; index < 16; ++index) {
    const InertialLog log = generator.make(index);
    families.insert(log.name.substr(0, log.name.find(' ')));
    for (std::size_t first = 0; first + 100 < log.truth.size(); first += 100) {
      const InertialLog::TrueState& begin = log.truth[first];
      const InertialLog::TrueState& end = log.truth[first + 100];  // 5 s later
      const ImuMotion measured =
          imu::preintegrate(log.samples, begin.time_ns, end.time_ns, {}, log.noise);
      ASSERT_TRUE(measured.valid);
      const Eigen::Matrix<double, 9, 1> error = imu::difference(
          measured, imu::motion_between(begin.nav, end.nav, 5.0, log.gravity_world));
      EXPECT_LT(error.head<3>().norm(), 1e-3) << log.name << ", state " << first;
      EXPECT_LT(error.segment<3>(3).norm(), 5e-3) << log.name << ", state " << first;
      EXPECT_LT(error.tail<3>().norm(), 1e-2) << log.name << ", state " << first;
    }
  }
  EXPECT_EQ(families.size(), 4U);
}

TEST(InertialLogGenerator, TheAccelerometerReadsGravityUpwards) {
  const InertialLogGenerator generator(without_errors(100.0));
  for (std::uint64_t index = 0; index < 8; ++index) {
    const InertialScenario scenario = generator.scenario(index);
    const InertialLog log = generator.make(index);
    Vector3d mean = Vector3d::Zero();
    for (const ImuSample& sample : log.samples) {
      const double t = static_cast<double>(sample.time_ns - log.samples.front().time_ns) * 1e-9;
      mean += scenario.motion.at(t).T_world_body.rotation() * sample.linear_acceleration;
    }
    mean /= static_cast<double>(log.samples.size());
    const double duration_s = scenario.motion.duration_s();
    const Vector3d change =
        scenario.motion.at(duration_s).v_world - scenario.motion.at(0.0).v_world;
    EXPECT_LT((mean - change / duration_s + log.gravity_world).norm(), 0.05) << log.name;
  }
}

TEST(InertialLogGenerator, StampsIncreaseAndTheTruthLiesBetweenThem) {
  InertialLogOptions options = short_logs();
  options.jitter_share = options.gap_share = 1.0;
  options.rate_hz = 0.0;
  const InertialLogGenerator generator(options);
  for (std::uint64_t index = 0; index < 12; ++index) {
    const InertialLog log = generator.make(index);
    const double period_ns = 1e9 / log.noise.rate_hz;
    double longest = 0.0;
    int uneven = 0;
    for (std::size_t i = 1; i < log.samples.size(); ++i) {
      const auto step = static_cast<double>(log.samples[i].time_ns - log.samples[i - 1].time_ns);
      ASSERT_GT(step, 0.7 * period_ns);
      longest = std::max(longest, step);
      uneven += std::abs(step - period_ns) > 1e-3 * period_ns ? 1 : 0;
    }
    EXPECT_GT(longest, 0.04e9);
    EXPECT_LT(longest, 4.1e9);  // four gaps may meet
    EXPECT_GT(uneven, static_cast<int>(log.samples.size() / 2));
    EXPECT_GE(log.truth.front().time_ns, log.samples.front().time_ns);
    EXPECT_LE(log.truth.back().time_ns, log.samples.back().time_ns);
    for (std::size_t i = 1; i < log.truth.size(); ++i) {
      ASSERT_EQ(log.truth[i].time_ns - log.truth[i - 1].time_ns, 50'000'000);
    }
  }
}

TEST(InertialLogGenerator, SharesDecideWhoCarriesTheSensor) {
  InertialLogOptions options = short_logs();
  options.drone_share = 0.6;
  options.hand_share = 0.0;
  options.car_share = 0.2;
  options.rover_share = 0.0;
  const InertialLogGenerator generator(options);
  int drones = 0;
  constexpr int kLogs = 200;
  for (std::uint64_t index = 0; index < kLogs; ++index) {
    const std::string family = generator.scenario(index).family;
    EXPECT_TRUE(family == "drone" || family == "car") << family;
    drones += family == "drone" ? 1 : 0;
  }
  EXPECT_NEAR(drones, 0.75 * kLogs, 20);  // 3.3 sigma
}

TEST(InertialLogGenerator, BadOptionsAreRefusedByName) {
  InertialLogOptions options;
  options.max_duration_s = 5.0;
  try {
    const InertialLogGenerator generator(options);
    FAIL();
  } catch (const InputError& error) {
    EXPECT_NE(std::string(error.what()).find("inertial.max_duration_s"), std::string::npos);
  }
  options = {};
  options.drone_share = options.hand_share = options.car_share = options.rover_share = 0.0;
  EXPECT_THROW(InertialLogGenerator{options}, InputError);
  options = {};
  Config config;
  config.section("inertial", options);
  config.set("inertial.car_share=0.9", "test");
  EXPECT_EQ(options.car_share, 0.9);
}

}  // namespace
}  // namespace imslam::training
