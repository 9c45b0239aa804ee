#pragma once

#include <ceres/sized_cost_function.h>

#include "pgo/pose_block.hpp"
#include "slam/sensors/motion.hpp"

namespace imslam::pgo {

/// What the camera's calibration is off by: global unknowns of the graph.
struct VisualCalibration {
  double disparity_offset = 0.0;  ///< [px], measured = true + offset
  double focal_error = 0.0;       ///< [1], true focal length = (1 + focal_error) stated
  /// [rad], true R_body_left = stated Exp(camera_rotation).
  Eigen::Vector3d camera_rotation = Eigen::Vector3d::Zero();
};

/// Holds two body poses to a measured motion, e.g. one step of visual odometry.
///
///   C(c)       = T_body_left Exp([0 c]) T_body_left^-1
///   M(d, f, c) = C T_body0_body1 C^-1 Exp(J_disparity_offset (d - disparity_offset) +
///                                         J_focal_error f)
///   r          = W Log(M(d, f, c)^-1  T_world_body0^-1  T_world_body1)
///
/// d, f and c are those of VisualCalibration. The motion was carried from the camera to the body by
/// the stated T_body_left; a camera that is turned by c against it has moved the body by C T C^-1.
/// W is the square root of the measurement's information, W^T W = Sigma^-1, tangent order
/// [rho theta]. r is counted in standard deviations.
///
/// Blocks: T_world_body0 (7), T_world_body1 (7), d (1), f (1), c (3).
class RelativePoseFactor final : public ceres::SizedCostFunction<6, 7, 7, 1, 1, 3> {
 public:
  using Vector6 = Eigen::Matrix<double, 6, 1>;
  using Matrix6 = Eigen::Matrix<double, 6, 6>;
  using Matrix63 = Eigen::Matrix<double, 6, 3>;

  /// r and its derivatives; `measurement`: right perturbation of T_body0_body1.
  struct Linearization {
    Vector6 residual;
    Matrix6 J_pose0;
    Matrix6 J_pose1;
    Vector6 J_disparity_offset;
    Vector6 J_focal_error;
    Matrix63 J_camera_rotation;
    Matrix6 J_measurement;
  };

  /// `sqrt_information` must be lower triangular (as from pgo::sqrt_information).
  RelativePoseFactor(const RelativeMotion& motion,
                     const Matrix6& sqrt_information,
                     const lie::SE3d& T_body_left = lie::SE3d());

  Vector6 residual(const lie::SE3d& T_world_body0,
                   const lie::SE3d& T_world_body1,
                   const VisualCalibration& calibration) const;

  /// The derivatives by the calibration and the measurement are left zero unless wanted: the solver
  /// mostly does without.
  Linearization linearize(const lie::SE3d& T_world_body0,
                          const lie::SE3d& T_world_body1,
                          const VisualCalibration& calibration,
                          bool want_measurement = true) const;

  bool Evaluate(double const* const* parameters,
                double* residuals,
                double** jacobians) const override;

 private:
  Vector6 shift(const VisualCalibration& calibration) const {
    return J_disparity_offset_ * (calibration.disparity_offset - disparity_offset_) +
           J_focal_error_ * calibration.focal_error;
  }
  /// C, identity for no rotation at all.
  lie::SE3d turn(const Eigen::Vector3d& camera_rotation) const;

  lie::SE3d T_body0_body1_;
  lie::SE3d T_body_left_;
  Vector6 J_disparity_offset_;
  Vector6 J_focal_error_;
  double disparity_offset_;
  Matrix6 sqrt_information_;
};

}  // namespace imslam::pgo
