#include <algorithm>
#include <cmath>

#include "datasets/simulation/motion_spline.hpp"
#include "datasets/simulation/paths.hpp"
#include "slam/training/inertial_motion.hpp"
#include "slam/training/motion_tracks.hpp"

namespace imslam::training {
namespace {

using Eigen::Vector3d;

constexpr double kFastest = 25.0;      ///< [m/s]
constexpr double kMostSideways = 4.0;  ///< [m/s^2]

/// Set-points by knot.
struct Drive {
  ScalarTrack speed;      ///< [m/s]
  ScalarTrack curvature;  ///< [1/m]
};

class Driver {
 public:
  Driver(double duration_s, Random& random)
      : count_(simulation::MotionSpline::control_count(kKnot_s, duration_s)),
        random_(random),
        stops_(random.chance(0.7)),
        usual_speed_(random.uniform(6.0, kFastest)),
        gain_(random.uniform(1.2, 3.0)),
        braking_(random.uniform(1.5, 4.0)) {}

  Drive drive() {
    if (stops_ && random_.chance(0.6)) {
      hold(random_.uniform(2.0, 20.0), 0.0, 0.0);
    } else {
      speed_ = usual_speed_;
    }
    while (drive_.speed.size() < count_) act();
    drive_.speed = smoothed(std::move(drive_.speed), 1.5);
    drive_.curvature = smoothed(std::move(drive_.curvature), 1.5);
    return drive_;
  }

 private:
  /// Speeds up or slows down towards `speed` and then stays there for `time_s`.
  void hold(double time_s, double speed, double curvature) {
    for (double t = 0.0; t < time_s && drive_.speed.size() < count_;) {
      const double change = std::clamp(speed - speed_, -braking_ * kKnot_s, gain_ * kKnot_s);
      speed_ += change;
      drive_.speed.push_back(speed_);
      const double limit = kMostSideways / std::max(speed_ * speed_, 1.0);
      drive_.curvature.push_back(std::clamp(curvature, -limit, limit));
      if (speed_ == speed) t += kKnot_s;
    }
  }

  void act() {
    const double kind = random_.uniform();
    const double side = random_.chance(0.5) ? 1.0 : -1.0;
    if (stops_ && kind < 0.2) {
      hold(random_.uniform(3.0, 30.0), 0.0, 0.0);
    } else if (kind < 0.4) {  // turns off
      const double speed = random_.uniform(3.0, 8.0);
      const double radius = random_.uniform(6.0, 25.0);
      hold(0.5, speed, 0.0);
      hold(random_.uniform(0.7, 1.8) * radius / speed, speed, side / radius);
    } else if (kind < 0.65) {  // a bend
      const double speed = usual_speed_ * random_.uniform(0.6, 1.0);
      const double sideways = random_.uniform(0.3, 3.0);
      hold(random_.uniform(2.0, 6.0), speed, side * sideways / (speed * speed));
    } else {
      const double speed = std::min(kFastest, usual_speed_ * random_.uniform(0.7, 1.2));
      const double time_s = random_.uniform(2.0, 12.0);
      hold(time_s, speed, 2e-4 * random_.normal());
    }
  }

  std::size_t count_;
  Random& random_;
  bool stops_;
  double usual_speed_;
  double gain_;     ///< [m/s^2]
  double braking_;  ///< [m/s^2]
  double speed_ = 0.0;
  Drive drive_;
};

/// Slopes belong to places, not to times: a car at rest stays on its slope.
struct Road {
  explicit Road(Random& random)
      : climb(random, random.uniform(0.0, 0.06), 0.001, 0.01),
        bank(random, random.uniform(0.0, 0.04), 0.002, 0.02),
        heave_m(log_uniform(random, 5e-4, 6e-3)),
        wobble(log_uniform(random, 7e-4, 7e-3)) {}

  simulation::Wobble climb;  ///< [rad] over the distance [m]
  simulation::Wobble bank;   ///< [rad]
  double heave_m;            ///< sigma of the body on its springs at speed
  double wobble;             ///< [rad] likewise
};

/// Engine and road, once a second.
std::vector<simulation::VibrationLevel> shaking(const ScalarTrack& speed, Random& random) {
  const double idle = random.chance(0.3) ? 0.0 : random.uniform(0.2, 0.6);
  const bool starts_cold = random.chance(0.3);
  std::vector<simulation::VibrationLevel> levels;
  const auto second = static_cast<std::size_t>(1.0 / kKnot_s);
  bool runs = !starts_cold;
  for (std::size_t k = 0; k < speed.size(); k += second) {
    const double soon = speed[std::min(k + 2 * second, speed.size() - 1)];
    runs = runs || soon > 0.1;  // the engine starts two seconds before the car
    const double tones = runs ? idle + 0.8 * speed[k] / 20.0 : 0.0;
    levels.push_back({simulation::MotionSpline::control_time(kKnot_s, k), tones, speed[k] / 15.0});
  }
  return levels;
}

}  // namespace

InertialMotion car_motion(double duration_s, Random random) {
  const Drive drive = Driver(duration_s, random).drive();
  const Road road(random);
  const std::size_t count = drive.speed.size();
  const double spring_s = random.uniform(0.35, 0.8);
  const VectorTrack bumps = smooth_noise3(random, count, 1.0, spring_s);
  const double roll_gain = random.uniform(0.003, 0.01);  // [rad per m/s^2]
  const double pitch_gain = random.uniform(0.002, 0.006);
  const double squat_s = 1.0 / kKnot_s;

  InertialMotion motion;
  motion.T_world_vehicle.reserve(count);
  Vector3d position = Vector3d::Zero();
  double yaw = random.uniform(0.0, 2.0 * M_PI);
  double distance = 0.0;
  for (std::size_t k = 0; k < count; ++k) {
    const double speed = drive.speed[k];
    const double shaken = std::min(1.0, speed / 10.0);
    const double gain = squat_s * (drive.speed[std::min(k + 1, count - 1)] - speed);
    const double sideways = speed * speed * drive.curvature[k];
    const double climb = road.climb(distance);
    const double roll =
        road.bank(distance) + roll_gain * sideways + shaken * road.wobble * bumps[k].x();
    // Positive pitch looks down: the nose rises uphill and when the car speeds up.
    const double pitch = -climb - pitch_gain * gain + shaken * road.wobble * bumps[k].y();
    const lie::SO3d R = lie::SO3d::exp(yaw * Vector3d::UnitZ()) *
                        lie::SO3d::exp(pitch * Vector3d::UnitY()) *
                        lie::SO3d::exp(roll * Vector3d::UnitX());
    const double heave = shaken * road.heave_m * bumps[k].z();
    motion.T_world_vehicle.emplace_back(R, position + heave * Vector3d::UnitZ());
    const double step = speed * kKnot_s;
    const double middle = yaw + 0.5 * step * drive.curvature[k];
    position += step * Vector3d(std::cos(climb) * std::cos(middle),
                                std::cos(climb) * std::sin(middle), std::sin(climb));
    yaw += step * drive.curvature[k];
    distance += step;
  }
  motion.vibration = shaking(drive.speed, random);
  return motion;
}

}  // namespace imslam::training
