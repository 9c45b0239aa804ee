#include "slam/system/slam_options.hpp"

#include <fmt/format.h>

#include <cmath>

#include "slam/base/config.hpp"
#include "slam/base/error.hpp"

namespace imslam::system {
namespace {

void require(bool good, const char* key, double value, const char* bound) {
  if (good) return;
  throw InputError(fmt::format("system.{} must be {}, got {}", key, bound, value),
                   ExitCode::kUsage);
}

}  // namespace

void SystemOptions::describe(Config& config) {
  config.field("front_end", front_end, {"klt", "learned"}, "which matcher sees");
  config.field("imu", imu, {"raw", "learned", "off"}, "which inertial measurements take part");
  config.field("preset", preset, {"default", "paper"}, "which graph");
  config.field("paper_weights", paper_weights, {"euroc", "kitti"}, "constants of preset paper");
  config.field("loops", loops, "views seen again tie the present to the past");
  config.field("online", online, "a sliding window also estimates while frames come in");
  config.field("focal_error_prior", focal_error_prior,
               "[1] standard deviation of the focal length's relative error before looking");
  config.field("camera_rotation_prior", camera_rotation_prior,
               "[rad] standard deviation of the camera's stated rotation before looking");
  config.field("trusted_gyro_bias", trusted_gyro_bias,
               "[rad/s] an IMU whose biases may be larger does not say how the camera is turned");
  config.field("coarse_gyro_noise", coarse_gyro_noise,
               "[rad/s/sqrt(Hz)] stated noise from which a gyro's scale and axes are estimated");
  config.field("gyro_shape_prior", gyro_shape_prior,
               "[1] standard deviation of a coarse gyro's scale and axes before looking");
  config.field("time_offset_s", time_offset_s,
               "[s] time offset to expect: stamp of the IMU less that of the camera");
  config.field("time_offset_prior_s", time_offset_prior_s,
               "[s] standard deviation of the time offset before looking");
  config.field("gyro_bias_prior", gyro_bias_prior,
               "[rad/s] standard deviation before looking, 0: by the kind of sensor");
  config.field("accel_bias_prior", accel_bias_prior,
               "[m/s^2] standard deviation before looking, 0: by the kind of sensor");
  config.field("gyro_noise_factor", gyro_noise_factor, "real over stated white noise of the gyro");
  config.field("accel_noise_factor", accel_noise_factor,
               "real over stated white noise of the accelerometer");
  config.field("vibration", vibration, "raw readings that shake more than that count less");
  config.field("gyro_walk_factor", gyro_walk_factor, "real over stated walk of the gyro's bias");
  config.field("accel_walk_factor", accel_walk_factor,
               "real over stated walk of the accelerometer's bias");
  config.field("relinearisations", relinearisations,
               "how often at most the IMU is integrated anew at the biases found");
  config.field("covariances", covariances, "compute the uncertainty of the final states");
  config.field("zero_velocity", zero_velocity, "hold the body where it rests");
  config.field("zero_velocity_sigma", zero_velocity_sigma, "[m/s] how still it rests");
  config.field("map_points_per_frame", map_points_per_frame, "points kept for map.pcd");
  config.field("map_max_depth_baselines", map_max_depth_baselines,
               "[baselines] farther points are left out of the map");
  config.field("map_voxel_m", map_voxel_m, "[m] one map point per cube of this side");
  config.field("device", device,
               "file with what fine-tuning found of this very device; empty: none");
  config.field("seed", seed, "recorded in the manifest");
}

void SystemOptions::validate() const {
  const auto positive = [](const char* key, double value) {
    require(value > 0.0, key, value, "positive");
  };
  positive("focal_error_prior", focal_error_prior);
  positive("camera_rotation_prior", camera_rotation_prior);
  positive("coarse_gyro_noise", coarse_gyro_noise);
  positive("gyro_shape_prior", gyro_shape_prior);
  require(trusted_gyro_bias >= 0.0, "trusted_gyro_bias", trusted_gyro_bias, "0 or more");
  require(std::abs(time_offset_s) <= 1.0, "time_offset_s", time_offset_s, "between -1 and 1");
  positive("time_offset_prior_s", time_offset_prior_s);
  require(gyro_bias_prior >= 0.0, "gyro_bias_prior", gyro_bias_prior, "0 or more");
  require(accel_bias_prior >= 0.0, "accel_bias_prior", accel_bias_prior, "0 or more");
  positive("gyro_noise_factor", gyro_noise_factor);
  positive("accel_noise_factor", accel_noise_factor);
  positive("gyro_walk_factor", gyro_walk_factor);
  positive("accel_walk_factor", accel_walk_factor);
  positive("zero_velocity_sigma", zero_velocity_sigma);
  positive("map_max_depth_baselines", map_max_depth_baselines);
  positive("map_voxel_m", map_voxel_m);
  require(map_points_per_frame >= 0, "map_points_per_frame", map_points_per_frame, "0 or more");
  require(relinearisations >= 0 && relinearisations <= 20, "relinearisations", relinearisations,
          "between 0 and 20");
  require(seed >= 0, "seed", seed, "0 or more");
}

void SlamOptions::describe(Config& config) {
  config.section("system", system);
  config.section("vo", vo);
  config.section("loops", loops);
  config.section("imu", preintegration);
  config.section("imu_network", imu_network);
  config.section("gyro_alignment", gyro_alignment);
  config.section("still", still);
  config.section("pgo", pgo);
  config.section("solver", solver);
  config.section("window", window);
}

void SlamOptions::validate() const {
  system.validate();
  vo.validate();
  loops.validate();
  preintegration.validate();
  gyro_alignment.validate();
  still.validate();
  pgo.validate();
  solver.validate();
  window.validate();
}

}  // namespace imslam::system
