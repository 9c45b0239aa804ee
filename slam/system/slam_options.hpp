#pragma once

#include <string>

#include "imu_net/gyro_alignment.hpp"
#include "imu_net/imu_weights.hpp"
#include "imu_net/preintegration.hpp"
#include "imu_net/static_detector.hpp"
#include "pgo/options.hpp"
#include "pgo/sliding_window.hpp"
#include "vo_net/loop_options.hpp"
#include "vo_net/visual_odometry.hpp"

namespace imslam {
class Config;
}

namespace imslam::system {

/// How the rooms play together.
struct SystemOptions {
  std::string front_end = "klt";        ///< which matcher sees: klt, learned
  std::string imu = "raw";              ///< which inertial measurements: raw, learned, off
  std::string preset = "default";       ///< which graph: default, paper (the published method's)
  std::string paper_weights = "euroc";  ///< constants of the paper preset: euroc, kitti
  bool loops = true;                    ///< views seen again tie the present to the past
  bool online = true;                   ///< a sliding window also estimates while frames come in

  double focal_error_prior = 0.005;     ///< [1] likewise, of a calibrated camera
  double camera_rotation_prior = 0.01;  ///< [rad] likewise, of a camera screwed to its IMU
  /// [rad/s] ImuNoise::gyro_bias_sigma up to which an IMU says how the camera is turned and, in
  /// fine-tuning, what its focal length is: units that compensate themselves. Larger for a gyro
  /// whose scale and axes were calibrated; those of a phone are askew themselves.
  double trusted_gyro_bias = 5e-3;
  /// [rad/s/sqrt(Hz)] stated noise from which a gyro counts as coarse: its scale and axes are then
  /// estimated. Better ones were calibrated with more care than a run can spend.
  double coarse_gyro_noise = 2.5e-4;
  double gyro_shape_prior = 0.005;    ///< [1] of a coarse gyro, each scale and axis, before looking
  double time_offset_s = 0.0;         ///< to expect: stamp of the IMU less the camera's
  double time_offset_prior_s = 0.02;  ///< standard deviation before looking
  double gyro_bias_prior = 0.0;       ///< [rad/s] likewise; 0: what the sensor's kind allows
  double accel_bias_prior = 0.0;      ///< [m/s^2] likewise
  double gyro_noise_factor = 2.0;     ///< [1] on the datasheet's density: see README, "noise"
  double accel_noise_factor = 8.0;    ///< [1] likewise; vibration and scale errors count as noise
  bool vibration = true;              ///< raw readings that shake more than that count less
  double gyro_walk_factor = 8.0;      ///< [1] on its bias walk: warming up is no random walk
  double accel_walk_factor = 1.0;     ///< [1] likewise
  int relinearisations = 4;  ///< the IMU is integrated anew at the biases found, at most so often
  bool covariances = true;   ///< of the final states, for the report

  bool zero_velocity = true;            ///< hold the body where IMU and vision say that it rests
  double zero_velocity_sigma = 0.01;    ///< [m/s]
  int map_points_per_frame = 40;        ///< kept for map.pcd
  double map_max_depth_baselines = 40;  ///< farther points are too uncertain for the map
  double map_voxel_m = 0.05;            ///< [m]
  std::string device;  ///< file of a DeviceCalibration; of another device: not used
  int seed = 0;        ///< recorded; nothing in the classical pipeline draws at random

  void describe(Config& config);
  void validate() const;  ///< throws InputError(kUsage)
};

/// All options of a run: one section per room.
struct SlamOptions {
  /// The graph of a run estimates the calibration unless told otherwise (pgo.estimate_...).
  SlamOptions() {
    // A motion that follows a moving thing pulls at Huber's kernel however far off it is.
    pgo.kernel = "cauchy_tail";
    pgo.kernel_width = 3.0;
    pgo.estimate_disparity_offset = true;
    pgo.estimate_focal_error = true;
    pgo.estimate_time_offset = true;
    pgo.estimate_camera_rotation = true;
    pgo.estimate_gyro_shape = true;
  }

  SystemOptions system;
  vo::VoOptions vo;
  vo::LoopOptions loops;
  imu::PreintegrationOptions preintegration;
  imu::ImuNetworkOptions imu_network;
  imu::GyroAlignmentOptions gyro_alignment;
  imu::StaticDetectorOptions still;
  pgo::GraphOptions pgo;
  pgo::SolverOptions solver;
  pgo::WindowOptions window;

  void describe(Config& config);
  void validate() const;
};

}  // namespace imslam::system
