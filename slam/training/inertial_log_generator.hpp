#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "datasets/simulation/imu_model.hpp"
#include "datasets/simulation/motion_spline.hpp"
#include "slam/training/inertial_log.hpp"
#include "slam/training/inertial_log_options.hpp"

namespace imslam::training {

/// Everything that decides a log but the noise.
struct InertialScenario {
  std::string family;               ///< drone, hand, car, rover
  simulation::MotionSpline motion;  ///< of the sensor; exactly at rest where the vehicle is
  lie::SE3d T_vehicle_sensor;
  std::vector<simulation::VibrationLevel> vibration;
  simulation::ImuErrors errors;
};

/// Endless made-up inertial logs with exact truth, for the training of the IMU network.
///
/// Log i depends on the options and i alone: not on the logs before it, nor on threads. Its true
/// states lie kTruthPeriod_s apart.
class InertialLogGenerator {
 public:
  static constexpr double kTruthPeriod_s = 0.05;

  /// Throws InputError(kUsage) on bad options.
  explicit InertialLogGenerator(const InertialLogOptions& options);

  /// Thread-safe.
  InertialLog make(std::uint64_t index) const;

  /// For those who want to know more than the log says.
  InertialScenario scenario(std::uint64_t index) const;

 private:
  InertialLogOptions options_;
};

}  // namespace imslam::training
