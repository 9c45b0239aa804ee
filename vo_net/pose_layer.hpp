#pragma once

#include <Eigen/Core>
#include <optional>
#include <string>
#include <vector>

#include "slam/base/config.hpp"
#include "slam/lie/se3.hpp"
#include "slam/sensors/calibration.hpp"
#include "vo_net/correspondence.hpp"
#include "vo_net/robust_kernel.hpp"

namespace imslam::vo {

struct PoseLayerOptions {
  std::string kernel = "cauchy";  ///< none, huber, cauchy, geman_mcclure
  double kernel_width = 2.0;      ///< where the kernel bends [standard deviations]
  bool adapt_noise_scale = true;  ///< estimate how far off the given informations are
  double min_noise_scale = 0.25;  ///< [1] ratio of true to stated standard deviation, at least
  double max_noise_scale = 8.0;   ///< [1] beyond it the points have no motion in common
  int start_iterations = 12;      ///< with a kernel that narrows as the residuals fall
  double consensus_share = 0.6;   ///< [1] fewer inliers: a motion is looked for by sampling, too
  int max_iterations = 30;        ///< after the start
  double tolerance = 1e-6;        ///< last step [standard deviations of the pose]
  double inlier_threshold = 4.0;  ///< [standard deviations]
  int min_inliers = 10;
  double max_sigma_translation = 1.0;  ///< [m] less certain results are not valid
  double max_sigma_rotation = 0.1;     ///< [rad]

  void describe(Config& config);
  void validate() const;
  RobustKernel robust_kernel() const;
};

struct PoseLayerResult {
  bool valid = false;      ///< false: the motion is not observable from these points
  bool converged = false;  ///< the last step was below tolerance
  int iterations = 0;
  double cost = 0.0;
  double noise_scale = 1.0;  ///< [1] true over stated standard deviation of the measurements

  lie::SE3d T_body0_body1;
  Eigen::Matrix<double, 6, 6> covariance = Eigen::Matrix<double, 6, 6>::Identity();

  int inliers = 0;
  std::vector<char> is_inlier;      ///< per correspondence
  std::vector<double> disparities;  ///< [px] in left0, the most likely ones, without the offset

  /// d(tangent of T_body0_body1)/d(disparity offset) [m/px, rad/px].
  Eigen::Matrix<double, 6, 1> J_disparity_offset = Eigen::Matrix<double, 6, 1>::Zero();
  double disparity_offset = 0.0;  ///< [px] the value this was computed with

  /// d(tangent of T_body0_body1)/d(relative error of the focal length, fx baseline held) [m, rad].
  Eigen::Matrix<double, 6, 1> J_focal_error = Eigen::Matrix<double, 6, 1>::Zero();

  /// Negative log-likelihood of a further offset x [px], pose and points free:
  /// offset_gradient x + offset_information x^2 / 2, in the scale of `covariance`.
  double offset_gradient = 0.0;
  double offset_information = 0.0;
};

/// A motion that something other than vision foretells, e.g. an IMU. It tells groups of points
/// apart; the result does not lean on it.
struct ForetoldMotion {
  lie::SO3d R_body0_body1;
  double sigma_rad = 0.0;                        ///< standard deviation per axis
  std::optional<Eigen::Vector3d> p_body0_body1;  ///< [m]; empty: the rotation alone is foretold
  double sigma_m = 0.0;
};

/// The most likely motion between two rectified stereo pairs.
///
///   min over T and d_k of  1/2 sum_k w_k rho(e_k^T Omega_k e_k)
///
///   X_k = back_project(left0_k, d_k),   (u v D) = project(T_left1_left0 X_k)
///   e_k = [u - u_left1,  v - v_left1,  d_k + offset - disparity0,  D + offset - disparity1]
///
/// Each point's true disparity d_k is an unknown, so the noise of both pairs counts; taking the
/// depth of one pair for granted would shorten the motion. The d_k are eliminated one by one (their
/// block is scalar), so a step costs O(points). Levenberg-Marquardt with exact second derivatives
/// near the end; a start with a wide kernel that narrows with the median residual bears gross
/// outliers.
///
/// Where few points agree on one motion, or on another than was foretold, groups that
/// move alike are looked for (find_consensus(), find_foretold()): things that move by
/// themselves and dirt on the lens may be more than what stands still.
///
/// `covariance` is that of an M-estimator (Huber, "Robust Statistics", 1981, eq. 7.6.2) and holds
/// for any scale of the informations. Non-finite correspondences count as outliers. Never throws
/// on bad data and never returns a non-finite number.
PoseLayerResult solve_pose(const Correspondences& correspondences,
                           const StereoCamera& camera,
                           const PoseLayerOptions& options,
                           const lie::SE3d& T_body0_body1_start = lie::SE3d(),
                           double disparity_offset = 0.0,
                           const std::optional<ForetoldMotion>& foretold = {});

}  // namespace imslam::vo
