#pragma once

#include <Eigen/Core>
#include <optional>
#include <vector>

#include "slam/base/config.hpp"
#include "slam/lie/so3.hpp"
#include "slam/sensors/calibration.hpp"
#include "vo_net/correspondence.hpp"

namespace imslam::vo {

struct ScaleOptions {
  double kernel_width = 1.5;      ///< where Huber's kernel bends [standard deviations]
  bool adapt_noise_scale = true;  ///< estimate how far off the given informations are
  double min_noise_scale = 0.25;  ///< [1] true over stated standard deviation, at least
  double max_noise_scale = 30.0;  ///< [1] beyond it the flow does not fit the motion's direction
  int max_rounds = 30;            ///< of reweighting
  double tolerance = 1e-10;       ///< last change [standard deviations of the scale]
  double inlier_threshold = 4.0;  ///< [standard deviations]
  double standing_still = 2.0;    ///< [standard deviations] shorter is no motion
  double backwards = 5.0;         ///< [standard deviations] s < -this: a contradiction

  void describe(Config& config);
  void validate() const;  ///< Throws InputError naming key, value and bound.
};

/// Rotation and direction of translation as a pose head gives them.
struct MotionDirection {
  lie::SO3d R_left0_left1;
  Eigen::Vector3d direction = Eigen::Vector3d::UnitZ();  ///< of p_left0_left1, of length 1
};

enum class ScaleState {
  kMoving,
  kStandingStill,  ///< no parallax beyond the noise: scale = 0
  kBackwards,      ///< the points say clearly that it goes against the direction: scale < 0
  kUnknown,        ///< no usable points, or none near enough: scale = 0
};

struct ScaleResult {
  ScaleState state = ScaleState::kUnknown;
  bool converged = false;
  int rounds = 0;
  double scale = 0.0;        ///< [m]
  double sigma = 0.0;        ///< [m] standard deviation for the given rotation and direction
  double noise_scale = 1.0;  ///< [1] true over stated standard deviation of the measurements
  int inliers = 0;
  std::vector<char> is_inlier;  ///< per correspondence

  // How the scale changes with what it was computed from; 0 unless it moves.
  Eigen::Vector3d J_rotation = Eigen::Vector3d::Zero();  ///< [m/rad] right tangent of R_left0_left1
  Eigen::Vector3d J_direction = Eigen::Vector3d::Zero();  ///< [m]
  double J_disparity_offset = 0.0;                        ///< [m/px]
};

/// The metric length s of a translation whose direction is known: robust one-dimensional least
/// squares from flow and depth.
///
///   p_left0_left1 = s d      Y_k(s) = R_left1_left0 (ray_k - s d disparity_k / (fx baseline))
///   e_k(s) = project(Y_k(s)) - left1_k                                                  [px]
///   sum_k w_k rho(e_k^T Omega_k e_k) -> min,   Omega_k = (Lambda_k^-1 + g_k g_k^T / lambda_k)^-1
///
/// Lambda, lambda: information of flow and disparity;  g = de/d(disparity): a near point's flow is
/// uncertain because its depth is. e is the published corrector's algebraic row divided by the
/// predicted depth, so far pixels do not dominate. Start: weighted median of what each point alone
/// says (least absolute deviations, bears gross outliers); then reweighting with Huber's kernel,
/// each round in closed form, to the root of
///
///   F(s) = sum_k w_k rho'_k e_k'^T Omega_k e_k = 0,   e' = de/ds
///
/// sigma^2 = noise_scale^2 / sum_k w_k rho'_k e_k'^T Omega_k e_k'.
///
/// Disparities are used less `disparity_offset`. Non-finite correspondences, those without depth
/// and those of weight 0 (left-right or forward-backward check failed) count for nothing. Never
/// throws on bad data and never returns a non-finite number.
ScaleResult correct_scale(const Correspondences& correspondences,
                          const StereoCamera& camera,
                          const MotionDirection& motion,
                          const ScaleOptions& options,
                          double disparity_offset = 0.0);

/// ds/d(every number of a Correspondence that counts).
struct ScalePointGradient {
  Eigen::Vector2d left0 = Eigen::Vector2d::Zero();             ///< [m/px]
  Eigen::Vector2d left1 = Eigen::Vector2d::Zero();             ///< [m/px]
  double disparity0 = 0.0;                                     ///< [m/px]
  Eigen::Matrix2d flow_information = Eigen::Matrix2d::Zero();  ///< [m px^2] symmetric
  double disparity0_information = 0.0;                         ///< [m px^2]
  double weight = 0.0;                                         ///< [m]
};

/// One per correspondence, for a result of correct_scale() with the same arguments:
///
///   ds/dz = -(dF/dz) / (dF/ds)          at F(s, z) = 0 (implicit function theorem)
///
/// The noise scale that fixes the kernel's width counts as a constant. Empty where there is no
/// derivative: the scale does not move (kMoving, kBackwards do), or not converged.
std::optional<std::vector<ScalePointGradient>> scale_gradient(
    const Correspondences& correspondences,
    const StereoCamera& camera,
    const MotionDirection& motion,
    const ScaleOptions& options,
    const ScaleResult& result,
    double disparity_offset = 0.0);

}  // namespace imslam::vo
