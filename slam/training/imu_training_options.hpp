#pragma once

#include <string>

#include "slam/base/config.hpp"
#include "slam/learner/training_options.hpp"
#include "slam/training/inertial_log_generator.hpp"

namespace imslam::training {

/// Training of the IMU network on simulated sensors or on real logs with truth.
struct ImuTrainingOptions : learner::TrainingOptions {
  ImuTrainingOptions() {
    steps = 2500;
    batch = 16;
    rate = 2e-3;
    warm_up = 100;
    validation_every = 250;
    validation_samples = 96;
  }

  std::string logs;             ///< real ones, comma separated; empty: simulation
  std::string validation_logs;  ///< real ones that choose among weights; empty: like `logs`
  int windows = 12;             ///< integrated per log and step
  double least_window_s = 0.1;  ///< [s]
  double most_window_s = 10.0;  ///< [s]
  double crop_s = 60.0;         ///< [s] of a real log per sample
  bool sensor_offset = false;   ///< learn the constant offset of one individual sensor

  InertialLogOptions simulation;

  void describe(Config& config);
  void validate() const;  ///< Throws InputError(kUsage) naming key, value and bound.
};

}  // namespace imslam::training
