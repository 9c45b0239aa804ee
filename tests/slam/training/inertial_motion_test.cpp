#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <vector>

#include "datasets/simulation/imu_model.hpp"
#include "datasets/simulation/motion_spline.hpp"
#include "imu_net/static_detector.hpp"
#include "slam/base/time.hpp"
#include "slam/training/inertial_log_generator.hpp"
#include "slam/training/inertial_motion.hpp"
#include "slam/training/motion_tracks.hpp"

namespace imslam::training {
namespace {

using Eigen::Vector3d;
using simulation::MotionSpline;
using simulation::MotionState;

constexpr double kDuration_s = 60.0;
constexpr std::uint64_t kLogs = 30;

template <typename Look>
void look_at(const InertialMotion& motion, const Look& look) {
  const MotionSpline spline(kKnot_s, motion.T_world_vehicle);
  for (double t = 0.0; t < kDuration_s; t += 0.02) look(t, spline.at(t));
}

bool at_rest(const MotionState& state) {
  return state.v_world.norm() < 1e-9 && state.omega_body.norm() < 1e-9 &&
         state.a_world.norm() < 1e-9;
}

double degrees_between(const Vector3d& a, const Vector3d& b) {
  return std::atan2(a.cross(b).norm(), a.dot(b)) * 180.0 / M_PI;
}

Vector3d up_in_body(const MotionState& state) {
  return state.T_world_body.rotation().inverse() * Vector3d::UnitZ();
}

double quantile(std::vector<double> values, double share) {
  std::sort(values.begin(), values.end());
  return values[static_cast<std::size_t>(share * static_cast<double>(values.size() - 1))];
}

TEST(InertialMotion, ADronesAccelerometerDoesNotSeeItsTilt) {
  std::vector<double> force_angle;
  std::vector<double> tilt;
  for (std::uint64_t seed = 0; seed < kLogs; ++seed) {
    look_at(drone_motion(kDuration_s, Random(seed)), [&](double, const MotionState& state) {
      EXPECT_LT(state.v_world.norm(), 5.0);
      EXPECT_LT(state.omega_body.norm(), 8.0);
      if (state.T_world_body.translation().z() < 0.3) return;
      force_angle.push_back(degrees_between(simulation::specific_force(state), Vector3d::UnitZ()));
      tilt.push_back(degrees_between(up_in_body(state), Vector3d::UnitZ()));
    });
  }
  EXPECT_LT(quantile(force_angle, 0.5), 2.0);
  EXPECT_LT(quantile(force_angle, 0.95), 5.0);
  EXPECT_LT(quantile(force_angle, 1.0), 15.0);
  EXPECT_GT(quantile(tilt, 0.95), 8.0);
  EXPECT_GT(quantile(tilt, 1.0), 25.0);
}

TEST(InertialMotion, ADroneRestsBeforeItsRotorsStartAndTheyStartBeforeItFlies) {
  int resting = 0;
  for (std::uint64_t seed = 0; seed < kLogs; ++seed) {
    const InertialMotion motion = drone_motion(kDuration_s, Random(seed));
    ASSERT_FALSE(motion.vibration.empty());
    double moves_s = kDuration_s;
    look_at(motion, [&](double t, const MotionState& state) {
      if (!at_rest(state)) moves_s = std::min(moves_s, t);
    });
    const simulation::VibrationLevel& first = motion.vibration.front();
    if (first.tones > 0.0) continue;  // begins in the air
    ++resting;
    EXPECT_GT(moves_s, first.time_s + 0.5) << seed;
    EXPECT_LT(moves_s, first.time_s + 8.0) << seed;
    for (std::size_t i = 1; i < motion.vibration.size(); ++i) {
      EXPECT_GT(motion.vibration[i].time_s, motion.vibration[i - 1].time_s) << seed;
    }
  }
  EXPECT_GT(resting, 18);
  EXPECT_LT(resting, 30);
}

TEST(InertialMotion, RestLooksStillToTheDetectorAndFlightDoesNot) {
  InertialLogOptions options;
  options.hand_share = options.car_share = options.rover_share = 0.0;
  options.vibration_scale = 0.0;
  options.bias_scale = 0.3;  // the detector must take larger ones for motion
  options.rate_hz = 200.0;
  options.min_duration_s = options.max_duration_s = 40.0;
  options.gap_share = 0.0;
  const InertialLogGenerator generator(options);
  int rests = 0;
  for (std::uint64_t index = 0; index < 20; ++index) {
    const InertialScenario scenario = generator.scenario(index);
    const simulation::VibrationLevel& rotors = scenario.vibration.front();
    if (rotors.tones > 0.0 || rotors.time_s < 3.0) continue;
    ++rests;
    const InertialLog log = generator.make(index);
    const std::int64_t start_ns = log.samples.front().time_ns;
    const auto still = [&](double from_s, double to_s) {
      return imu::assess_stillness(log.samples, start_ns + to_nanoseconds(from_s),
                                   start_ns + to_nanoseconds(to_s), log.noise)
          .still;
    };
    EXPECT_TRUE(still(0.0, 2.5)) << log.name;
    EXPECT_FALSE(still(0.0, 39.0)) << log.name;
  }
  EXPECT_GE(rests, 5);
}

TEST(InertialMotion, AHandShakesWalksAndSometimesPutsDown) {
  double fastest = 0.0;
  int rested = 0;
  int walked = 0;
  for (std::uint64_t seed = 0; seed < kLogs; ++seed) {
    bool rests = false;
    Vector3d far = Vector3d::Zero();
    look_at(hand_motion(kDuration_s, Random(seed)), [&](double, const MotionState& state) {
      fastest = std::max(fastest, state.omega_body.norm());
      rests = rests || at_rest(state);
      EXPECT_LT(state.v_world.norm(), 4.0) << seed;
      EXPECT_LT(state.a_world.norm(), 40.0) << seed;
      far = state.T_world_body.translation();
    });
    rested += rests ? 1 : 0;
    walked += far.norm() > 3.0 ? 1 : 0;
  }
  EXPECT_GT(fastest, 4.0);
  EXPECT_LT(fastest, 9.0);
  EXPECT_GT(rested, 15);
  EXPECT_GT(walked, 10);
}

TEST(InertialMotion, ACarKeepsToItsWheelsAndItsSpeedLimit) {
  int stopped = 0;
  double fastest = 0.0;
  for (std::uint64_t seed = 0; seed < kLogs; ++seed) {
    bool stops = false;
    look_at(car_motion(kDuration_s, Random(seed)), [&](double, const MotionState& state) {
      const Vector3d v_body = state.T_world_body.rotation().inverse() * state.v_world;
      EXPECT_GT(v_body.x(), -0.05) << seed;
      EXPECT_LT(std::abs(v_body.y()), 0.05 + 0.03 * v_body.x()) << seed;
      EXPECT_LT(state.a_world.norm(), 7.0) << seed;
      EXPECT_LT(degrees_between(up_in_body(state), Vector3d::UnitZ()), 10.0) << seed;
      fastest = std::max(fastest, v_body.x());
      stops = stops || at_rest(state);
    });
    stopped += stops ? 1 : 0;
  }
  EXPECT_GT(fastest, 18.0);
  EXPECT_LT(fastest, 25.5);
  EXPECT_GT(stopped, 10);
  EXPECT_LT(stopped, 28);
}

TEST(InertialMotion, ARoverIsSlowAndStaysOnTheGround) {
  double fastest = 0.0;
  for (std::uint64_t seed = 0; seed < kLogs; ++seed) {
    look_at(rover_motion(kDuration_s, Random(seed)), [&](double, const MotionState& state) {
      fastest = std::max(fastest, state.v_world.norm());
      EXPECT_LT(std::abs(state.T_world_body.translation().z()), 0.2) << seed;
      EXPECT_LT(degrees_between(up_in_body(state), Vector3d::UnitZ()), 20.0) << seed;
      EXPECT_LT(state.omega_body.norm(), 3.0) << seed;
    });
  }
  EXPECT_GT(fastest, 0.8);
  EXPECT_LT(fastest, 2.2);
}

TEST(MotionTracks, SmoothingKeepsWhatIsConstantAndTheSumOfSteps) {
  ScalarTrack steps(200, 0.0);
  std::fill(steps.begin() + 80, steps.begin() + 120, 2.0);
  const ScalarTrack smooth = smoothed(steps, 0.9);  // 19 knots
  EXPECT_NEAR(smooth[70], 0.0, 1e-15);
  EXPECT_GT(smooth[73], 0.0);
  EXPECT_NEAR(smooth[100], 2.0, 1e-14);
  EXPECT_NEAR(integrated(smooth, 0.0).back(), 40 * kKnot_s * 2.0, 1e-12);
  for (std::size_t k = 1; k < smooth.size(); ++k) {
    EXPECT_LE(smooth[k] - smooth[k - 1], 2.0 * 2.25 * kKnot_s / 0.9);
  }
}

TEST(MotionTracks, SmoothNoiseHasItsSigma) {
  Random random(5);
  double sum = 0.0;
  const ScalarTrack noise = smooth_noise(random, 100000, 0.3, 1.0);
  for (const double value : noise) sum += value * value;
  EXPECT_NEAR(std::sqrt(sum / 100000.0), 0.3, 0.01);
}

}  // namespace
}  // namespace imslam::training
