#pragma once

#include <filesystem>

#include "slam/training/inertial_log.hpp"
#include "slam/training/truth_gravity.hpp"
#include "slam/training/truth_velocity.hpp"

namespace imslam::training {

struct InertialLogFileOptions {
  /// p_cam0 = T p_imu, for truth of a camera; empty: PATH/NAME_T_cam0_imu.txt or
  /// PATH/T_cam0_imu.txt.
  std::filesystem::path T_cam0_imu;

  /// What the truth of a real log is uncertain of; velocity 0: what its fit or check has found.
  /// Trackers do not state it: a twentieth of a degree and a millimetre are good ones.
  TruthSigma truth{1e-3, 5e-4, 0.0, 1e-3};
};

/// A log and what had to be found out about its truth.
struct InertialLogReading {
  InertialLog log;
  VelocityFit velocity;
  GravityFit gravity;
};

/// Reads what a user has:
///
///   a EuRoC folder       mav0/imu0/{data.csv, sensor.yaml}; truth of state_groundtruth_estimate0,
///                        mocap0 or vicon0, velocities too where its csv has them
///   a prefix PATH/NAME   NAME_imu.csv (EuRoC columns) and one of
///                          NAME_truth.tum   T_world_body on the clock of the samples
///                          NAME_poses.txt   KITTI, camera 0; stamps: NAME_times.txt, or multiples
///                                           of the "nominal interval X s" that a comment of
///                                           NAME_imu.csv states; the world is turned z up
///                        NAME_imu.yaml      optional: noise, keys as in EuRoC's sensor.yaml;
///                                           else that of an ADIS16448 or, for KITTI, of its OXTS
///
/// True states outside the samples are left out. Velocities that no file states are fitted
/// (fit_velocities), gravity always is (fit_gravity): worlds are off level by a fraction of a
/// degree.
/// InputError: kData "file:line: ..." as datasets' readers, kCalibration for yaml and extrinsics.
InertialLogReading read_inertial_log(const std::filesystem::path& path,
                                     const InertialLogFileOptions& options = {});

}  // namespace imslam::training
