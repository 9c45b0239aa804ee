#pragma once

#include "datasets/simulation/imu_model.hpp"
#include "slam/base/random.hpp"
#include "slam/training/inertial_log_options.hpp"

namespace imslam::training {

/// The errors of one made-up sensor. Every magnitude lies around the typical one of a drawn grade
/// (tactical, industrial, mems, phone), a third to three times, and the datasheet (`data_sheet`)
/// is wrong by a half to two, as datasheets are. The biases do not follow the grade:
///
///   |gyro| log-uniform in [1e-4, 0.15] rad/s,   |accel| log-uniform in [1e-3, 0.5] m/s^2,
///
/// because an estimator must not be able to guess them (EuRoC's industrial sensor: 0.08 rad/s).
/// `vibration_rms` [m/s^2] is what the vehicle does to the sensor.
simulation::ImuErrors draw_sensor(const InertialLogOptions& options,
                                  double vibration_rms,
                                  Random random);

/// How a sensor sits in its vehicle: half of them anyhow, the others along its axes within some
/// degrees.
lie::SO3d draw_mounting(Random& random);

}  // namespace imslam::training
