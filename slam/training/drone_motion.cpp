#include <algorithm>
#include <cmath>

#include "datasets/simulation/imu_model.hpp"
#include "datasets/simulation/motion_spline.hpp"
#include "slam/training/inertial_motion.hpp"
#include "slam/training/motion_tracks.hpp"

namespace imslam::training {
namespace {

using Eigen::Vector3d;

constexpr double kLowest_m = 0.8;  ///< set-points do not go below while it flies
constexpr double kHighest_m = 15.0;
constexpr double kContact_m = 0.15;  ///< height at which the ground no longer decides the attitude

/// Character of the pilot and of the weather.
struct Flight {
  explicit Flight(Random& random)
      : speed(log_uniform(random, 0.5, 4.0)),
        width_s(std::clamp(2.25 * speed / random.uniform(1.0, 7.0), 0.9, 4.0)),
        climb_width_s(1.5 * width_s + 0.4),
        drag(random.uniform(0.05, 0.4)),
        wind(random.chance(0.5) ? random.uniform(0.0, 1.2) : 0.1),
        jitter_m(log_uniform(random, 5e-5, 8e-4)),
        turning(random.uniform(0.2, 1.2)) {}

  double speed;          ///< [m/s] of the fastest commands
  double width_s;        ///< [s] over which commands are smoothed
  double climb_width_s;  ///< [s] likewise, of climbing: thrust must stay well above zero
  double drag;           ///< [1/s]
  double wind;           ///< [m/s] sigma per axis
  double jitter_m;       ///< [m] sigma of the controller's restlessness
  double turning;        ///< [rad/s] sigma of the commanded yaw rates
};

/// Commands by knot, and what happens when.
struct Commands {
  VectorTrack velocity;  ///< [m/s]
  ScalarTrack yaw_rate;  ///< [rad/s]
  double start_height = 0.0;
  std::vector<simulation::VibrationLevel> vibration;
};

class Pilot {
 public:
  Pilot(const Flight& flight, double duration_s, Random& random)
      : flight_(flight),
        duration_s_(duration_s),
        count_(simulation::MotionSpline::control_count(kKnot_s, duration_s)),
        random_(random) {}

  Commands fly() {
    const bool lands = random_.chance(0.35);
    const double descent_s = lands ? duration_s_ - random_.uniform(8.0, 20.0) : 1e9;
    start();
    while (commands_.velocity.size() < count_ && now_s() < descent_s) manoeuvre();
    if (lands) land();
    hold(1e9, Vector3d::Zero(), 0.0);
    return commands_;
  }

 private:
  double now_s() const {
    return simulation::MotionSpline::control_time(kKnot_s, commands_.velocity.size());
  }

  void hold(double time_s, const Vector3d& velocity, double yaw_rate) {
    const double until_s = now_s() + time_s;
    while (commands_.velocity.size() < count_ && now_s() < until_s) {
      commands_.velocity.push_back(velocity);
      commands_.yaw_rate.push_back(yaw_rate);
      height_ += kKnot_s * velocity.z();
    }
  }

  void start() {
    if (random_.chance(0.2)) {
      height_ = commands_.start_height = random_.uniform(1.0, 6.0);
      commands_.vibration = {{0.0, 1.0, 1.0}};
      return;
    }
    hold(random_.uniform(0.0, std::min(15.0, 0.4 * duration_s_)), Vector3d::Zero(), 0.0);
    const double rotors_s = now_s();
    const double idle = random_.uniform(0.2, 0.8);
    hold(random_.uniform(1.0, 5.0) + 0.5 * flight_.climb_width_s, Vector3d::Zero(), 0.0);
    const double take_off_s = now_s() - 0.5 * flight_.climb_width_s;
    commands_.vibration = {{rotors_s, 0.0, 0.0},
                           {rotors_s + 0.8, idle, idle},
                           {take_off_s, idle, idle},
                           {take_off_s + 0.2, 1.0, 1.0}};
    const double climb = random_.uniform(0.4, 1.0) * std::min(2.0, 0.5 + flight_.speed);
    const double height = std::max(random_.uniform(1.0, 4.0), kLowest_m + 0.1);
    hold(std::max(height / climb, 0.5 * flight_.climb_width_s), climb * Vector3d::UnitZ(), 0.0);
  }

  void manoeuvre() {
    const bool turns = random_.chance(0.5);
    const double yaw_rate = turns ? flight_.turning * random_.normal() : 0.0;
    if (random_.chance(0.25)) {  // hovers
      const double rest_s = random_.uniform(1.0, 6.0);
      hold(rest_s, Vector3d::Zero(), random_.chance(0.5) ? yaw_rate : 0.0);
      return;
    }
    const double time_s = random_.uniform(0.8, 4.0);
    const double heading = random_.uniform(0.0, 2.0 * M_PI);
    const double speed = flight_.speed * random_.uniform();
    // Gentler than the horizontal commands: rotors push upwards only.
    double climb = 0.4 * flight_.speed * random_.uniform(-1.0, 1.0);
    const double height = height_ + climb * time_s;
    if (height < kLowest_m || height > kHighest_m) climb = -climb;
    climb = std::clamp(climb, (kLowest_m - height_) / time_s, (kHighest_m - height_) / time_s);
    hold(time_s, {speed * std::cos(heading), speed * std::sin(heading), climb}, yaw_rate);
  }

  void land() {
    hold(flight_.width_s + 0.5, Vector3d::Zero(), 0.0);
    const double descent = random_.uniform(0.3, 1.0);
    const double knots = std::ceil(height_ / (descent * kKnot_s));
    hold((knots - 0.5) * kKnot_s, {0.0, 0.0, -height_ / (knots * kKnot_s)}, 0.0);
    const double touch_s = now_s() + 0.5 * flight_.climb_width_s;
    const double off_s = touch_s + random_.uniform(0.2, 2.0);
    commands_.vibration.push_back({touch_s, 1.0, 1.0});
    commands_.vibration.push_back({touch_s + 0.2, 0.4, 0.4});
    commands_.vibration.push_back({off_s + 0.2, 0.4, 0.4});
    commands_.vibration.push_back({off_s + 1.2, 0.0, 0.0});
  }

  const Flight& flight_;
  double duration_s_;
  std::size_t count_;
  Random& random_;
  double height_ = 0.0;
  Commands commands_;
};

/// 0 on the ground, 1 in the air, smooth.
double lifted(double height_m) {
  const double x = std::clamp(height_m / kContact_m, 0.0, 1.0);
  return x * x * (3.0 - 2.0 * x);
}

/// Second derivative of a spline's positions, sharpened: the spline rounds attitudes more than it
/// rounds accelerations, by two boxes of one knot or, to second order, by a twelfth of the second
/// difference; the thrust shall still point along the acceleration.
VectorTrack felt_acceleration(const VectorTrack& position) {
  const auto second_difference = [](const VectorTrack& track, std::size_t k) -> Vector3d {
    const std::size_t inner = std::clamp<std::size_t>(k, 1, track.size() - 2);
    return track[inner + 1] - 2.0 * track[inner] + track[inner - 1];
  };
  VectorTrack rough(position.size());
  for (std::size_t k = 0; k < position.size(); ++k) {
    rough[k] = second_difference(position, k) / (kKnot_s * kKnot_s);
  }
  VectorTrack sharp(position.size());
  for (std::size_t k = 0; k < position.size(); ++k) {
    sharp[k] = rough[k] - second_difference(rough, k) / 12.0;
  }
  return sharp;
}

/// The shortest rotation that carries z to `up`, a unit vector that does not point down.
lie::SO3d tilt_towards(const Vector3d& up) {
  return lie::SO3d(Eigen::Quaterniond(1.0 + up.z(), -up.y(), up.x(), 0.0));
}

}  // namespace

InertialMotion drone_motion(double duration_s, Random random) {
  const Flight flight(random);
  Commands commands = Pilot(flight, duration_s, random).fly();
  const std::size_t count = commands.velocity.size();
  VectorTrack velocity = smoothed(commands.velocity, flight.width_s);
  const VectorTrack climbing = smoothed(std::move(commands.velocity), flight.climb_width_s);
  for (std::size_t k = 0; k < count; ++k) velocity[k].z() = climbing[k].z();
  const ScalarTrack yaw =
      integrated(smoothed(std::move(commands.yaw_rate), 0.6), random.uniform(0.0, 2.0 * M_PI));
  VectorTrack position = integrated(velocity, Vector3d(0.0, 0.0, commands.start_height));
  const VectorTrack wind = smooth_noise3(random, count, flight.wind, random.uniform(1.0, 4.0));
  const VectorTrack jitter = smooth_noise3(random, count, flight.jitter_m, 0.3);
  const Vector3d ground =
      Vector3d{0.03 * random.normal(), 0.03 * random.normal(), 1.0}.normalized();

  ScalarTrack air(count);
  for (std::size_t k = 0; k < count; ++k) {
    air[k] = lifted(position[k].z());
    position[k] += air[k] * jitter[k];
  }
  const VectorTrack acceleration = felt_acceleration(position);
  InertialMotion motion;
  motion.T_world_vehicle.reserve(count);
  for (std::size_t k = 0; k < count; ++k) {
    const Vector3d thrust = acceleration[k] + simulation::kGravity * Vector3d::UnitZ() +
                            flight.drag * (velocity[k] - wind[k]);
    const Vector3d up = ((1.0 - air[k]) * ground + air[k] * thrust.normalized()).normalized();
    const lie::SO3d R = tilt_towards(up) * lie::SO3d::exp(yaw[k] * Vector3d::UnitZ());
    motion.T_world_vehicle.emplace_back(R, position[k]);
  }
  motion.vibration = std::move(commands.vibration);
  return motion;
}

}  // namespace imslam::training
