#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <vector>

#include "imu_net/imu_buffer.hpp"
#include "slam/sensors/imu.hpp"
#include "slam/sensors/trajectory.hpp"

namespace imslam::training {

/// A bias that holds from `time_ns` until the next one.
struct StampedBias {
  std::int64_t time_ns = 0;
  ImuBias bias;
};

/// The entry that holds at `time_ns`: the last one not later, or else the first; nullptr if none.
const StampedBias* bias_at(const std::vector<StampedBias>& biases, std::int64_t time_ns);

struct GravityFitOptions {
  double interval_s = 1.0;          ///< [s] of each of the two motions that make a bend
  double chunk_s = 20.0;            ///< [s] over which the bias counts as constant
  double direction_sigma = 0.1;     ///< [rad] of gravity about -z before looking
  double magnitude = 9.81;          ///< [m/s^2]; it cannot be told from the accelerometer's bias
  double gyro_noise_factor = 2.0;   ///< [1] on the datasheet's density: what a moving body has
  double accel_noise_factor = 8.0;  ///< [1] likewise
};

struct GravityFit {
  Eigen::Vector3d gravity_world{0.0, 0.0, -9.81};  ///< [m/s^2]
  double tilt = 0.0;                               ///< [rad] away from -z
  double tilt_sigma = 0.0;                         ///< [rad] larger of its two axes; formal
  std::vector<StampedBias> biases;                 ///< that fit best, one per chunk
};

/// The direction of gravity in the truth's world that makes readings and poses agree: rotations and
/// bends of the path (truth_bend.hpp), with one bias per chunk, by Gauss-Newton over the whole log.
GravityFit fit_gravity(imu::ImuRange samples,
                       const ImuNoise& noise,
                       const Trajectory& truth,
                       const GravityFitOptions& options = {});

}  // namespace imslam::training
