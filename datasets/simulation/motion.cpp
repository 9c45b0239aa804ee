#include "datasets/simulation/motion.hpp"

#include <algorithm>
#include <cmath>
#include <utility>
#include <vector>

#include "datasets/simulation/imu_model.hpp"

namespace imslam::simulation {
namespace {

constexpr double kKnot_s = 0.1;
constexpr double kRamp_s = 2.0;  ///< from rest to full speed

/// Travelling time at clock time t: zero during the rest, then a smooth start.
/// Its rate is 3x^2 - 2x^3 over the ramp; this is the integral.
double travelled(double t, double rest_s) {
  const double x = (t - rest_s) / kRamp_s;
  if (x <= 0.0) return 0.0;
  if (x < 1.0) return kRamp_s * x * x * x * (1.0 - 0.5 * x);
  return kRamp_s * (x - 0.5);
}

lie::SE3d special_pose(const SimulationOptions& options, const lie::SE3d& start, double t) {
  const double moving = travelled(t, options.rest_s);
  if (options.motion == "pure_rotation") {
    const Eigen::Vector3d wave(0.25 * std::sin(0.9 * moving), 0.2 * std::sin(1.3 * moving),
                               0.5 * moving + 0.3 * std::sin(0.7 * moving));
    return start * lie::SE3d(lie::SO3d::exp(wave), Eigen::Vector3d::Zero());
  }
  if (options.motion == "free_fall") {
    // Thrown upwards so that it is back where it started when the sequence ends.
    const double height = 0.5 * kGravity * t * (options.duration_s - t);
    return lie::SE3d(lie::SO3d(), {0.0, 0.0, height}) * start;
  }
  return start;
}

}  // namespace

double travel_time(const SimulationOptions& options, double t) {
  return options.speed * travelled(t, options.rest_s);
}

MotionSpline make_motion(const SimulationOptions& options,
                         const std::function<lie::SE3d(double)>& path) {
  const double duration = options.duration_s + 1.0 / options.frame_rate_hz;
  const std::size_t count = MotionSpline::control_count(kKnot_s, duration);
  const lie::SE3d start = path(0.0);
  std::vector<lie::SE3d> controls;
  controls.reserve(count);
  for (std::size_t k = 0; k < count; ++k) {
    const double t = MotionSpline::control_time(kKnot_s, k);
    controls.push_back(options.motion == "natural" ? path(travel_time(options, t))
                                                   : special_pose(options, start, t));
  }
  return MotionSpline(kKnot_s, std::move(controls));
}

}  // namespace imslam::simulation
