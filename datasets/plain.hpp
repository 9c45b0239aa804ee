#pragma once

#include <filesystem>

#include "datasets/recording.hpp"

namespace imslam::datasets {

/// Your own recording in the simplest layout.
///
///   left/, right/      PNG or JPEG; names are stamps in nanoseconds, or numbers with a times.txt
///   times.txt          optional: [s], line i belongs to image i (as KITTI odometry)
///   imu.csv            optional: time_ns, w_x, w_y, w_z [rad/s], a_x, a_y, a_z [m/s^2]
///   truth.tum          optional: T_world_body, TUM format
///   calib.yaml         cameras and IMU, see below; or Kalibr's camchain-imucam.yaml
///                      (camchain.yaml without IMU), with an optional imu.yaml for the noise
///
/// calib.yaml, raw cameras (they are rectified):
///
///   left:
///     size: [752, 480]                          # px
///     intrinsics: [458.7, 457.3, 367.2, 248.4]  # fx, fy, cx, cy in px
///     distortion: radtan                        # radtan, equidistant or none
///     coefficients: [-0.283, 0.074, 0.0002, 1.8e-5]
///     T_body_camera: [16 numbers, row by row]   # p_body = T p_camera; body = IMU
///   right: (the same keys)
///   imu:                                        # optional, any of
///     gyroscope_noise_density: 1.7e-4           # rad/s/sqrt(Hz)
///     gyroscope_random_walk: 2.0e-5             # rad/s^2/sqrt(Hz)
///     accelerometer_noise_density: 2.0e-3       # m/s^2/sqrt(Hz)
///     accelerometer_random_walk: 3.0e-3         # m/s^3/sqrt(Hz)
///     rate_hz: 200
///
/// calib.yaml, rectified images:
///
///   rectified:
///     size: [1241, 376]
///     intrinsics: [718.9, 718.9, 607.2, 185.2]
///     baseline: 0.537                           # m
///     T_body_left: [16 numbers]                 # needed with imu.csv only
///   imu: (as above)
///
/// Kalibr: T_cam_imu carries points from the IMU to the camera; timeshift_cam_imu is applied.
Recording read_plain(const std::filesystem::path& folder);

bool looks_like_plain(const std::filesystem::path& folder);

}  // namespace imslam::datasets
