#pragma once

#include <string>

namespace imslam {
class Config;
}

namespace imslam::pgo {

/// What the pose-velocity graph models and which of its global unknowns it estimates.
struct GraphOptions {
  double gravity_magnitude = 9.81;  ///< [m/s^2]

  std::string kernel = "huber";  ///< of visual edges: none, huber, cauchy, cauchy_tail
  double kernel_width = 4.0;     ///< [1] standard deviations of the whitened 6-dof residual's norm

  double gyro_random_walk = 2.0e-5;   ///< [rad/s^2/sqrt(Hz)]
  double accel_random_walk = 3.0e-3;  ///< [m/s^3/sqrt(Hz)]

  bool estimate_gravity = false;           ///< direction; only with a first pose fixed in 6 dof
  bool estimate_disparity_offset = false;  ///< needs motion with parallax
  bool estimate_focal_error = false;       ///< needs turns and a gyro that measures them
  bool estimate_time_offset = false;       ///< camera to IMU; needs changing rates
  bool estimate_camera_rotation = false;   ///< against the IMU; needs turns, and axes to trust
  bool estimate_gyro_shape = false;        ///< its scale and axes; needs turns about all of them

  void describe(Config& config);
  void validate() const;
};

/// Levenberg-Marquardt with a sparse Cholesky factorisation of the normal equations.
///
/// The result does not depend on the thread count, bit for bit. There is no time limit for the
/// same reason.
struct SolverOptions {
  int max_iterations = 50;
  double function_tolerance = 1e-9;    ///< stop when |cost change| / cost is below
  double gradient_tolerance = 1e-10;   ///< stop when the gradient's largest entry is below
  double parameter_tolerance = 1e-12;  ///< stop when |step| / |state| is below
  /// Large: the first steps are Gauss-Newton steps. A graph that starts near its minimum, as a
  /// chain of odometry does, needs 2-3 times as many steps with the cautious default of 1e4.
  double initial_trust_region = 1e10;
  int threads = 2;  ///< for the evaluation of factors

  void describe(Config& config);
  void validate() const;
};

}  // namespace imslam::pgo
