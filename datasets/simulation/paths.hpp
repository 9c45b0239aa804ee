#pragma once

#include <Eigen/Core>
#include <array>
#include <vector>

#include "slam/base/random.hpp"

namespace imslam::simulation {

/// A smooth restless number: a few sines of random frequency and phase, at most `amplitude`.
class Wobble {
 public:
  Wobble(Random& random, double amplitude, double low_hz, double high_hz);
  double operator()(double t) const;

 private:
  struct Wave {
    double amplitude;
    double rate;  ///< [rad/s]
    double phase;
  };
  std::array<Wave, 4> waves_;
};

/// A closed curve in the plane, travelled again and again at a speed that suits its bends.
class PlanarLoop {
 public:
  struct Limits {
    double speed = 1.0;          ///< [m/s]
    double turn_rate = 1.0;      ///< [rad/s]
    double lateral_accel = 2.0;  ///< [m/s^2]
    double smoothing_m = 1.0;    ///< corners are rounded over about this length
  };
  struct Pose {
    Eigen::Vector2d position;  ///< [m]
    double yaw = 0.0;          ///< [rad], continuous over laps
    double distance = 0.0;     ///< [m] travelled
  };

  /// `corners`: the closed polygon; it is resampled, smoothed and timed.
  PlanarLoop(const std::vector<Eigen::Vector2d>& corners, const Limits& limits);

  Pose at_time(double t) const;
  Pose at_distance(double s) const;
  double length() const { return distances_.back(); }  ///< [m]
  double lap_time() const { return times_.back(); }    ///< [s]
  const std::vector<Eigen::Vector2d>& points() const { return points_; }

  /// Distance [m] of a place to the curve.
  double clearance(const Eigen::Vector2d& place) const;

 private:
  void resample(const std::vector<Eigen::Vector2d>& corners, double step);
  void measure();
  void time_it(const Limits& limits, int half_width);
  Pose at_index(double index) const;

  std::vector<Eigen::Vector2d> points_;  ///< the last one precedes the first
  std::vector<double> yaws_;             ///< continuous; one more than points
  std::vector<double> distances_;        ///< [m]; one more than points
  std::vector<double> times_;            ///< [s]; one more than points
};

/// Arc of a circle as corner points, for building polygons.
void add_arc(std::vector<Eigen::Vector2d>& points,
             const Eigen::Vector2d& centre,
             double radius,
             double from,
             double to);

}  // namespace imslam::simulation
