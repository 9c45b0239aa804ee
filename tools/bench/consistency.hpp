#pragma once

#include <cstdint>
#include <vector>

namespace imslam::bench {

/// A Monte-Carlo study of the back end: are its covariances the truth about its errors?
struct ConsistencyOptions {
  int runs = 50;
  int frames = 200;
  double frame_rate_hz = 20.0;
  double imu_rate_hz = 200.0;
  double visual_sigma_m = 2e-3;    ///< per frame and axis
  double visual_sigma_rad = 3e-4;  ///< per frame and axis
  double gyro_bias_sigma = 0.01;   ///< [rad/s] of the bias that each run draws
  double accel_bias_sigma = 0.05;  ///< [m/s^2]
  double noise = 1.0;              ///< scale of all noise; 0: exact measurements
  std::uint64_t seed = 1;
};

/// The average of e^T P^-1 e over all frames of a run, over the runs. Frames of one run share their
/// errors, runs do not: (mean - dof) / standard_error is a fair test, whatever the frames share.
struct RunAverage {
  double mean = 0.0;
  double standard_error = 0.0;

  double deviation(int dof) const { return (mean - dof) / standard_error; }
};

/// Average of e^T P^-1 e over the runs, per frame (the first frame is the anchor and left out).
struct ConsistencyResult {
  std::vector<double> pose_nees;      ///< 6 dof: expected 6
  std::vector<double> velocity_nees;  ///< 3 dof: expected 3
  RunAverage pose;
  RunAverage velocity;
  double pose_inside = 0.0;  ///< share of frames inside the 95 % band of the average
  double velocity_inside = 0.0;
  double largest_position_error_m = 0.0;
};

/// Each run: 200 Hz readings of a smooth motion with white noise and walking biases, preintegrated
/// with the wrong (zero) bias, and visual motions with Gaussian noise, no outliers. The truth is
/// the exact readings integrated by the same rule, so that the rule's own error plays no part.
ConsistencyResult study_consistency(const ConsistencyOptions& options);

/// Bounds of the central 95 % of chi2(dof * runs) / runs (Wilson-Hilferty approximation).
struct Band {
  double low;
  double high;
};
Band average_nees_band(int dof, int runs);

}  // namespace imslam::bench
