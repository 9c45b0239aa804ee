#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <optional>
#include <vector>

#include "datasets/simulation/motion_spline.hpp"
#include "datasets/simulation/options.hpp"
#include "datasets/simulation/vibration.hpp"
#include "slam/base/random.hpp"
#include "slam/sensors/imu.hpp"

namespace imslam::simulation {

inline constexpr double kGravity = 9.81;  ///< [m/s^2], along -z of the world

/// What an ideal accelerometer reads, R^T (a - g) [m/s^2].
Eigen::Vector3d specific_force(const MotionState& state);

/// The errors of one individual sensor:
///
///   gyro  = quantise(clamp(M_g rate  + G force + bias_g + vibration + noise))
///   accel = quantise(clamp(M_a force           + bias_a + vibration + noise))
///   bias  = initial bias + random walk + drift (1 - exp(-t / drift_time))
struct ImuErrors {
  ImuNoise noise;       ///< true densities; zero for a perfect sensor
  ImuNoise data_sheet;  ///< what is written in sensor.yaml: never zero
  ImuBias initial_bias;
  Eigen::Matrix3d gyro_shape = Eigen::Matrix3d::Identity();  ///< scale and misalignment
  Eigen::Matrix3d accel_shape = Eigen::Matrix3d::Identity();
  Eigen::Matrix3d g_sensitivity = Eigen::Matrix3d::Zero();  ///< G [rad/s per m/s^2]
  ImuBias drift;                                            ///< of a sensor that has warmed up
  double drift_time_s = 60.0;                               ///< [s]
  double vibration = 0.0;                                   ///< [m/s^2] rms per axis at level 1
  double gyro_step = 0.0;                                   ///< [rad/s] quantisation, 0: none
  double accel_step = 0.0;                                  ///< [m/s^2]
};

ImuErrors draw_imu_errors(const ImuOptions& options, Random random);

/// A reading together with what it should have been.
struct SimulatedImuSample {
  double time_s = 0.0;  ///< since the start of the motion
  ImuSample reading;
  ImuBias bias;  ///< at that instant, drift included
  MotionState truth;
};

/// Samples a motion one reading at a time; only bias and vibration are state.
class ImuModel {
 public:
  /// `motion` must outlive the model. `start_ns` is the stamp of the motion's beginning. `levels`
  /// say when the vehicle vibrates; see Vibration.
  ImuModel(const ImuErrors& errors,
           const MotionSpline& motion,
           std::int64_t start_ns,
           const Random& random,
           const std::vector<VibrationLevel>& levels = {});

  SimulatedImuSample next();

 private:
  ImuBias drift_at(double time_s) const;

  ImuErrors errors_;
  const MotionSpline* motion_;
  std::int64_t start_ns_;
  Random random_;
  ImuBias bias_;  ///< without the drift
  std::optional<Vibration> vibration_;
  bool feels_force_;
  bool drifts_;
  std::int64_t count_ = 0;
};

}  // namespace imslam::simulation
