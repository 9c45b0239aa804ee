#include <algorithm>
#include <cmath>

#include "datasets/simulation/motion_spline.hpp"
#include "slam/training/inertial_motion.hpp"
#include "slam/training/motion_tracks.hpp"

namespace imslam::training {
namespace {

using Eigen::Vector3d;

/// How much of each kind of motion there is, by knot.
struct Activity {
  ScalarTrack carried;    ///< 0 on the table, 1 in the hand
  ScalarTrack swayed;     ///< strength of the swaying
  ScalarTrack shaken;     ///< angle of the shaking [rad]
  ScalarTrack speed;      ///< of the walk [m/s]
  ScalarTrack stepping;   ///< 1 while walking
  ScalarTrack turn_rate;  ///< of the person [rad/s]
};

/// What is decided once per log.
struct Person {
  explicit Person(Random& random)
      : shake_hz(random.uniform(1.5, 3.0)),
        shake_angle(random.uniform(3.0, 5.5) / (2.0 * M_PI * shake_hz)),
        step_hz(random.uniform(1.5, 2.2)),
        walk_speed(step_hz * random.uniform(0.45, 0.75)),
        bounce_m(random.uniform(0.012, 0.035)) {}

  double shake_hz;
  double shake_angle;  ///< [rad], so that rates reach 3 to 5.5 rad/s
  double step_hz;
  double walk_speed;  ///< [m/s]
  double bounce_m;
};

class Schedule {
 public:
  Schedule(const Person& person, double duration_s, Random& random)
      : person_(person),
        count_(simulation::MotionSpline::control_count(kKnot_s, duration_s)),
        random_(random) {}

  Activity make() {
    if (random_.chance(0.6)) hold(random_.uniform(1.0, 15.0), 0.0);
    const bool puts_down = random_.chance(0.2);
    const auto busy = static_cast<std::size_t>(
        puts_down ? static_cast<double>(count_) - random_.uniform(4.0, 8.0) / kKnot_s : 1e9);
    while (length() < std::min(count_, busy)) act();
    hold(1e9, 0.0);
    for (ScalarTrack* track : {&activity_.carried, &activity_.swayed, &activity_.shaken,
                               &activity_.speed, &activity_.stepping, &activity_.turn_rate}) {
      *track = smoothed(std::move(*track), 1.2);
    }
    return activity_;
  }

 private:
  std::size_t length() const { return activity_.carried.size(); }

  void hold(
      double time_s, double carried, double swayed = 0.0, double shaken = 0.0, bool walks = false) {
    const double turn_rate = walks && random_.chance(0.6) ? 0.6 * random_.normal() : 0.0;
    const double speed = walks ? person_.walk_speed * random_.uniform(0.7, 1.1) : 0.0;
    for (double t = 0.0; t < time_s && length() < count_; t += kKnot_s) {
      activity_.carried.push_back(carried);
      activity_.swayed.push_back(swayed);
      activity_.shaken.push_back(shaken);
      activity_.speed.push_back(speed);
      activity_.stepping.push_back(walks ? 1.0 : 0.0);
      activity_.turn_rate.push_back(turn_rate);
    }
  }

  void act() {
    const double kind = random_.uniform();
    if (kind < 0.08) return hold(random_.uniform(3.0, 12.0), 0.0);       // put down again
    if (kind < 0.25) return hold(random_.uniform(1.0, 6.0), 1.0, 0.05);  // held as still as can be
    if (kind < 0.55) {
      const double time_s = random_.uniform(2.0, 10.0);
      return hold(time_s, 1.0, random_.uniform(0.3, 1.5));
    }
    if (kind < 0.7) {
      const double strength = random_.uniform(0.2, 1.0);
      return hold(random_.uniform(1.0, 4.0), 1.0, 0.5, strength * person_.shake_angle);
    }
    const double time_s = random_.uniform(3.0, 15.0);
    hold(time_s, 1.0, random_.uniform(0.1, 0.6), 0.0, true);
  }

  const Person& person_;
  std::size_t count_;
  Random& random_;
  Activity activity_;
};

/// Up and down twice, sidewards once per double step; the angles of the trunk go along.
struct Gait {
  Vector3d offset;  ///< [m] in the walker's frame
  Vector3d angles;  ///< [rad]
};

Gait gait_at(const Person& person, double time_s) {
  const double phase = 2.0 * M_PI * person.step_hz * time_s;
  const double up = std::sin(phase) + 0.3 * std::sin(2.0 * phase + 0.8);
  const double side = std::sin(0.5 * phase);
  const double forward = 0.4 * std::cos(phase);
  return {person.bounce_m * Vector3d(forward, 0.8 * side, up),
          Vector3d(0.02 * side, 0.015 * std::sin(phase + 0.5), 0.03 * std::cos(0.5 * phase))};
}

}  // namespace

InertialMotion hand_motion(double duration_s, Random random) {
  const Person person(random);
  const Activity activity = Schedule(person, duration_s, random).make();
  const std::size_t count = activity.carried.size();
  const double tempo_s = random.uniform(0.8, 2.5);  // what sways faster sways less
  const VectorTrack sway = smooth_noise3(
      random, count, std::pow(0.4 * tempo_s, 1.5) * log_uniform(random, 0.02, 0.25), tempo_s);
  const VectorTrack lean =
      smooth_noise3(random, count, 0.4 * tempo_s * log_uniform(random, 0.1, 0.7), tempo_s);
  const VectorTrack tremor = smooth_noise3(random, count, log_uniform(random, 2e-4, 2e-3), 0.0);
  const double tumbling = random.chance(0.25) ? random.uniform(0.2, 0.7) : 0.0;
  const VectorTrack tumble = smooth_noise3(random, count, tumbling, 2.0);
  const ScalarTrack yaw = integrated(activity.turn_rate, random.uniform(0.0, 2.0 * M_PI));

  const Vector3d lift{random.uniform(-0.3, 0.3), random.uniform(-0.3, 0.3),
                      random.uniform(0.1, 0.7)};
  const Vector3d grip = 0.5 * random.normal3();
  const Vector3d shake_axis = random.normal3().normalized();
  const Vector3d shake_path = 0.15 * random.normal3();  // [m/rad]
  lie::SO3d tumbled;
  Vector3d walked = Vector3d::Zero();

  InertialMotion motion;
  motion.T_world_vehicle.reserve(count);
  for (std::size_t k = 0; k < count; ++k) {
    const double t = simulation::MotionSpline::control_time(kKnot_s, k);
    const double carried = activity.carried[k];
    const lie::SO3d heading = lie::SO3d::exp(yaw[k] * Vector3d::UnitZ());
    const Gait gait = gait_at(person, t);
    const double angle = activity.shaken[k] * std::sin(2.0 * M_PI * person.shake_hz * t);
    walked += kKnot_s * activity.speed[k] * (heading * Vector3d::UnitX());
    tumbled = tumbled * lie::SO3d::exp(kKnot_s * activity.swayed[k] * tumble[k]);
    const Vector3d offset = carried * lift + activity.swayed[k] * sway[k] +
                            activity.stepping[k] * gait.offset + angle * shake_path;
    const Vector3d theta = carried * (grip + tremor[k]) + activity.swayed[k] * lean[k] +
                           activity.stepping[k] * gait.angles;
    const lie::SO3d R =
        heading * lie::SO3d::exp(theta) * tumbled * lie::SO3d::exp(angle * shake_axis);
    motion.T_world_vehicle.emplace_back(R, walked + heading * offset);
  }
  return motion;
}

}  // namespace imslam::training
