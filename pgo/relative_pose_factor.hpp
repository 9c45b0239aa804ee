#pragma once

#include <ceres/sized_cost_function.h>

#include "pgo/pose_block.hpp"
#include "slam/sensors/motion.hpp"

namespace imslam::pgo {

/// Holds two body poses to a measured motion, e.g. one step of visual odometry.
///
///   M(d, f) = T_body0_body1 Exp(J_disparity_offset (d - disparity_offset) + J_focal_error f)
///   r       = W Log(M(d, f)^-1  T_world_body0^-1  T_world_body1)
///
/// d [px] is the constant disparity offset of the stereo rectification, f [1] the relative error of
/// the focal length, both global unknowns. W is the
/// square root of the measurement's information, W^T W = Sigma^-1, tangent order [rho theta]. r is
/// counted in standard deviations.
///
/// Blocks: T_world_body0 (7), T_world_body1 (7), d (1), f (1).
class RelativePoseFactor final : public ceres::SizedCostFunction<6, 7, 7, 1, 1> {
 public:
  using Vector6 = Eigen::Matrix<double, 6, 1>;
  using Matrix6 = Eigen::Matrix<double, 6, 6>;

  /// r and its derivatives; `measurement`: right perturbation of T_body0_body1.
  struct Linearization {
    Vector6 residual;
    Matrix6 J_pose0;
    Matrix6 J_pose1;
    Vector6 J_disparity_offset;
    Vector6 J_focal_error;
    Matrix6 J_measurement;
  };

  /// `sqrt_information` must be lower triangular (as from pgo::sqrt_information).
  RelativePoseFactor(const RelativeMotion& motion, const Matrix6& sqrt_information);

  Vector6 residual(const lie::SE3d& T_world_body0,
                   const lie::SE3d& T_world_body1,
                   double disparity_offset,
                   double focal_error) const;

  /// The derivatives by the calibration and the measurement are left zero unless wanted: the solver
  /// mostly does without.
  Linearization linearize(const lie::SE3d& T_world_body0,
                          const lie::SE3d& T_world_body1,
                          double disparity_offset,
                          double focal_error,
                          bool want_measurement = true) const;

  bool Evaluate(double const* const* parameters,
                double* residuals,
                double** jacobians) const override;

 private:
  Vector6 shift(double disparity_offset, double focal_error) const {
    return J_disparity_offset_ * (disparity_offset - disparity_offset_) +
           J_focal_error_ * focal_error;
  }

  lie::SE3d T_body0_body1_;
  Vector6 J_disparity_offset_;
  Vector6 J_focal_error_;
  double disparity_offset_;
  Matrix6 sqrt_information_;
};

}  // namespace imslam::pgo
