#pragma once

#include <string>
#include <vector>

#include "pgo/graph_data.hpp"

namespace imslam::pgo {

struct InitializationOptions {
  double gravity_magnitude = 9.81;         ///< [m/s^2]
  double gravity_tolerance = 0.1;          ///< largest relative misfit of the measured magnitude
  double accel_bias_sigma = 0.2;           ///< [m/s^2] prior about the bias of the motions
  double max_gravity_sigma_rad = 0.03;     ///< less certain gravity is a failure
  double visual_rotation_floor = 1e-4;     ///< [rad] added to what vision claims
  double visual_translation_floor = 1e-4;  ///< [m] likewise
  double min_duration_s = 0.4;             ///< [s] of intervals with both vision and IMU
  int min_intervals = 5;                   ///< with both

  void validate() const;
};

/// First guesses of all states, from vision and IMU alone.
///
/// World: z up, position of the first body zero, and the horizontal part of the first body's x axis
/// along world x (its z axis where x is within 30 degrees of the vertical, as on EuRoC's vehicle).
struct Initialization {
  bool success = false;
  std::string reason;         ///< why not, for people
  std::vector<State> states;  ///< one more than intervals
  ImuBias bias;               ///< gyro: fitted; accel: as far as the data tell
  Eigen::Vector3d gravity_body0 = Eigen::Vector3d::Zero();  ///< [m/s^2]
  double gravity_sigma_rad = 0.0;                           ///< of the direction
};

/// visual[i] and inertial[i] say how frame i became frame i + 1; either may be invalid.
///
///   gyro bias     min sum |Log(dR_i(b)^T R_i)|^2, Gauss-Newton with Huber weights
///   then linear   v_j - v_i - g dt         = R_i (dv_i + J_ba ba)     and
///                 t_i - v_i dt - g dt^2 / 2 = R_i (dp_i + J_ba ba)    in g, ba, all v
///
/// with |g| held to its known magnitude in a second round on the sphere. Needs no motion: at rest g
/// is what the accelerometer reads. The bias correction is first order: integrate again with the
/// bias found and repeat if it is large (over 0.05 rad/s).
Initialization initialize(const std::vector<RelativeMotion>& visual,
                          const std::vector<ImuMotion>& inertial,
                          const InitializationOptions& options = {});

/// Rotation that brings `gravity_body0` to world -z and the heading of body 0 to zero, see above.
lie::SO3d level(const Eigen::Vector3d& gravity_body0);

}  // namespace imslam::pgo
