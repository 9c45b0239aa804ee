#pragma once

#include <Eigen/Core>
#include <optional>
#include <vector>

#include "imu_net/imu_buffer.hpp"
#include "imu_net/preintegration.hpp"
#include "slam/sensors/imu.hpp"
#include "slam/sensors/motion.hpp"

namespace imslam {
class Config;
}

namespace imslam::imu {

struct GyroAlignmentOptions {
  bool estimate_time_offset = true;
  bool estimate_rotation = false;       ///< also the small correction of R_body_left
  double max_time_offset_s = 0.1;       ///< [s] half width of the search
  double search_step_s = 0.005;         ///< [s] of the search before the fit
  double vision_rotation_floor = 1e-4;  ///< [rad] added to the standard deviation vision claims
  double time_offset_prior_s = 0.05;  ///< [s] standard deviation about zero before anything is seen
  double observed_offset_std_s = 0.005;  ///< [s] a less certain offset is taken as zero
  double rotation_prior = 0.02;          ///< [rad] likewise
  double robust_width = 2.0;             ///< Huber's bend in robust standard deviations
  int min_motions = 10;
  int max_iterations = 20;

  void describe(Config& config);
  void validate() const;  ///< throws InputError(kUsage)
};

/// Where gyroscope and camera agree best; the error state of `covariance` is
/// [gyro_bias time_offset rotation]. What was not estimated has zero rows.
struct GyroAlignment {
  Eigen::Vector3d gyro_bias = Eigen::Vector3d::Zero();  ///< [rad/s]
  double time_offset_s = 0.0;                           ///< [s], t_imu = t_camera + time_offset
  /// R_body_left_true = Exp(rotation_correction) R_body_left, body frame [rad].
  Eigen::Vector3d rotation_correction = Eigen::Vector3d::Zero();
  Eigen::Matrix<double, 7, 7> covariance = Eigen::Matrix<double, 7, 7>::Zero();

  double residual_scale = 0.0;    ///< robust size of the whitened residuals: 1 if all is calibrated
  double residual_rms_rad = 0.0;  ///< [rad] of the inliers, per motion
  int motions = 0;
  int inliers = 0;  ///< within 3 robust standard deviations
  int iterations = 0;
  bool converged = false;
  bool time_offset_observed = false;  ///< else time_offset_s is 0, its covariance the prior's
};

/// Fits gyro bias, camera-IMU time offset and, if asked, the camera's mounting to vision's
/// rotations by robust Gauss-Newton over
///
///   r_k = Log( dR_k(b, t_d)^T Exp(c) R_k Exp(-c) ),   R_k: rotation of T_body0_body1
///
/// weighted with the covariances of both, scaled to the residuals' actual spread. The time offset
/// starts at the best of a search by correlation of the rates. Invalid and degraded motions are
/// left out. Empty with fewer than min_motions of them.
std::optional<GyroAlignment> align_gyro(const std::vector<RelativeMotion>& vision,
                                        ImuRange samples,
                                        const ImuNoise& noise,
                                        const GyroAlignmentOptions& options = {});

/// The offset [s] within +-max_time_offset_s at which gyro and vision agree best in angular
/// velocity, whatever the bias. Empty with fewer than min_motions motions inside the samples.
std::optional<double> search_time_offset(const std::vector<RelativeMotion>& vision,
                                         ImuRange samples,
                                         const ImuNoise& noise,
                                         const GyroAlignmentOptions& options = {});

}  // namespace imslam::imu
