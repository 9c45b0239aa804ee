#pragma once

#include <Eigen/Core>
#include <cstdint>

#include "datasets/simulation/motion_spline.hpp"
#include "datasets/simulation/options.hpp"
#include "slam/base/random.hpp"
#include "slam/sensors/imu.hpp"

namespace imslam::simulation {

inline constexpr double kGravity = 9.81;  ///< [m/s^2], along -z of the world

/// What an ideal accelerometer reads, R^T (a - g) [m/s^2].
Eigen::Vector3d specific_force(const MotionState& state);

/// The errors of one individual sensor:  reading = quantise(clamp(M truth + bias + noise)).
struct ImuErrors {
  ImuNoise noise;       ///< true densities; zero for a perfect sensor
  ImuNoise data_sheet;  ///< what is written in sensor.yaml: never zero
  ImuBias initial_bias;
  Eigen::Matrix3d gyro_shape = Eigen::Matrix3d::Identity();  ///< scale and misalignment
  Eigen::Matrix3d accel_shape = Eigen::Matrix3d::Identity();
  double gyro_step = 0.0;   ///< [rad/s] quantisation, 0: none
  double accel_step = 0.0;  ///< [m/s^2]
};

ImuErrors draw_imu_errors(const ImuOptions& options, Random random);

/// A reading together with what it should have been.
struct SimulatedImuSample {
  double time_s = 0.0;  ///< since the start of the motion
  ImuSample reading;
  ImuBias bias;  ///< at that instant
  MotionState truth;
};

/// Samples a motion one reading at a time; only the bias is state.
class ImuModel {
 public:
  /// `motion` must outlive the model. `start_ns` is the stamp of the motion's beginning.
  ImuModel(const ImuErrors& errors,
           const MotionSpline& motion,
           std::int64_t start_ns,
           const Random& random);

  SimulatedImuSample next();

 private:
  ImuErrors errors_;
  const MotionSpline* motion_;
  std::int64_t start_ns_;
  Random random_;
  ImuBias bias_;
  std::int64_t count_ = 0;
};

}  // namespace imslam::simulation
