#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

#include "slam/lie/nav_state.hpp"
#include "slam/sensors/imu.hpp"
#include "slam/sensors/motion.hpp"

namespace imslam::training {

/// How uncertain the truth is: standard deviations per axis. Nothing for simulated logs.
struct TruthSigma {
  double tilt = 0.0;      ///< [rad] of all attitudes together: gravity leaks into the velocity
  double rotation = 0.0;  ///< [rad] of each attitude by itself
  double velocity = 0.0;  ///< [m/s]
  double position = 0.0;  ///< [m]
};

/// Readings of an inertial sensor and the truth about its motion.
struct InertialLog {
  struct TrueState {
    std::int64_t time_ns = 0;  ///< of the sensor's clock
    lie::NavState nav;
  };

  std::string name;
  std::vector<ImuSample> samples;  ///< stamps increase strictly
  ImuNoise noise;                  ///< datasheet
  std::vector<TrueState> truth;    ///< stamps increase strictly, within those of the samples
  Eigen::Vector3d gravity_world{0.0, 0.0, -9.81};  ///< [m/s^2]
  std::vector<std::size_t> truth_jumps;  ///< true states that do not go on from the one before
  TruthSigma truth_sigma;
};

/// A stretch of a log over which its readings are integrated, and what they should have given.
struct IntegrationWindow {
  std::size_t first = 0;  ///< index of the true state it begins with
  std::size_t last = 0;
  ImuMotion motion;  ///< times, dR, dv, dp and covariance of the truth; see imu::motion_between()
};

/// The window between two true states.
IntegrationWindow true_window(const InertialLog& log, std::size_t first, std::size_t last);

/// Whether the truth jumps on the way from state `first` to state `last`.
bool jumps_between(const InertialLog& log, std::size_t first, std::size_t last);

}  // namespace imslam::training
