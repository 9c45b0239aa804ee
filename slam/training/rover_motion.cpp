#include <algorithm>
#include <cmath>

#include "datasets/simulation/motion_spline.hpp"
#include "slam/training/inertial_motion.hpp"
#include "slam/training/motion_tracks.hpp"

namespace imslam::training {
namespace {

using Eigen::Vector3d;

/// Set-points by knot.
struct Wheels {
  ScalarTrack speed;      ///< [m/s], backwards if negative
  ScalarTrack turn_rate;  ///< [rad/s]
};

Wheels drive(std::size_t count, Random& random) {
  const double top_speed = log_uniform(random, 0.2, 2.0);
  const double top_turn = random.uniform(0.3, 1.5);
  Wheels wheels;
  const auto hold = [&](double time_s, double speed, double turn_rate) {
    for (double t = 0.0; t < time_s && wheels.speed.size() < count; t += kKnot_s) {
      wheels.speed.push_back(speed);
      wheels.turn_rate.push_back(turn_rate);
    }
  };
  if (random.chance(0.6)) hold(random.uniform(1.0, 12.0), 0.0, 0.0);
  while (wheels.speed.size() < count) {
    const double kind = random.uniform();
    const double turn = top_turn * random.uniform(-1.0, 1.0);
    const double speed = top_speed * random.uniform(0.3, 1.0);
    if (kind < 0.2) {
      hold(random.uniform(1.0, 10.0), 0.0, 0.0);
    } else if (kind < 0.35) {  // on the spot
      hold(random.uniform(0.5, 3.0), 0.0, turn);
    } else if (kind < 0.42) {
      hold(random.uniform(1.0, 3.0), -0.5 * speed, 0.3 * turn);
    } else {
      const double time_s = random.uniform(2.0, 10.0);
      hold(time_s, speed, random.chance(0.5) ? 0.4 * turn : 0.0);
    }
  }
  const double reaction_s = std::clamp(2.25 * top_speed / random.uniform(0.5, 2.5), 0.4, 3.0);
  wheels.speed = smoothed(std::move(wheels.speed), reaction_s);
  wheels.turn_rate = smoothed(std::move(wheels.turn_rate), reaction_s);
  return wheels;
}

/// 0 at rest, near 1 in motion.
double moving(const Wheels& wheels, std::size_t k) {
  return std::min(1.0, 2.0 * std::abs(wheels.speed[k]) + std::abs(wheels.turn_rate[k]));
}

std::vector<simulation::VibrationLevel> rumble(const Wheels& wheels, Random& random) {
  const double hum = random.uniform(0.0, 0.5);  // of fans and the like, also at rest
  std::vector<simulation::VibrationLevel> levels;
  for (std::size_t k = 0; k < wheels.speed.size(); k += 4) {
    const double level = moving(wheels, k);
    const double tones = level > 1e-6 ? hum + level : hum * (k > 0 ? 1.0 : 0.0);
    levels.push_back({simulation::MotionSpline::control_time(kKnot_s, k), tones, level});
  }
  return levels;
}

}  // namespace

InertialMotion rover_motion(double duration_s, Random random) {
  const std::size_t count = simulation::MotionSpline::control_count(kKnot_s, duration_s);
  const Wheels wheels = drive(count, random);
  const bool rough = random.chance(0.4);             // ground rather than floor
  const double length_s = random.uniform(0.3, 1.5);  // of a bump, at full motion
  const double unevenness =
      length_s * (rough ? log_uniform(random, 5e-3, 0.06) : log_uniform(random, 1e-4, 5e-3));
  const double heave_m =
      length_s * length_s *
      (rough ? log_uniform(random, 1e-3, 0.02) : log_uniform(random, 2e-5, 1e-3));
  const VectorTrack ground = smooth_noise3(random, count, 1.0, length_s);
  const double tilt_x = 0.01 * random.normal();
  const double tilt_y = 0.01 * random.normal();

  InertialMotion motion;
  motion.T_world_vehicle.reserve(count);
  Vector3d position = Vector3d::Zero();
  double yaw = random.uniform(0.0, 2.0 * M_PI);
  double covered = 0.0;  // of the ground, in knots at full motion: what rests keeps its tilt
  for (std::size_t k = 0; k < count; ++k) {
    const auto place = static_cast<std::size_t>(covered);
    const double share = covered - static_cast<double>(place);
    const Vector3d here =
        (1.0 - share) * ground[place] + share * ground[std::min(place + 1, count - 1)];
    covered += moving(wheels, k);
    const lie::SO3d R = lie::SO3d::exp(Vector3d(tilt_x, tilt_y, 0.0)) *
                        lie::SO3d::exp(yaw * Vector3d::UnitZ()) *
                        lie::SO3d::exp(unevenness * Vector3d(here.x(), here.y(), 0.0));
    motion.T_world_vehicle.emplace_back(R, position + heave_m * here.z() * Vector3d::UnitZ());
    const double middle = yaw + 0.5 * kKnot_s * wheels.turn_rate[k];
    position += kKnot_s * wheels.speed[k] * Vector3d(std::cos(middle), std::sin(middle), 0.0);
    yaw += kKnot_s * wheels.turn_rate[k];
  }
  motion.vibration = rumble(wheels, random);
  return motion;
}

}  // namespace imslam::training
