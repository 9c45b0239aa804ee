#pragma once

#include <ceres/sized_cost_function.h>

#include "pgo/pose_block.hpp"
#include "slam/sensors/motion.hpp"

namespace imslam::pgo {

/// Holds two poses and velocities to the preintegrated IMU motion between them.
///
///   x  = J_dR_bias (b - bias) + J_time_offset_R (t - time_offset),   dv, dp corrected alike
///   rR = Log((dR Exp(x))^T Exp((I + S) Log(R0^T R1)))
///   rv = R0^T (v1 - v0 - g dt)                  - dv(b, t)
///   rp = R0^T (p1 - p0 - v0 dt - g dt^2 / 2)    - dp(b, t)
///   r  = W [rR rv rp],   g = gravity magnitude * direction
///
/// Source: Forster et al., "On-Manifold Preintegration", TRO 2017, eq. (44), (45).
///
/// Blocks: T_world_body0 (7), v0_world (3), T_world_body1 (7), v1_world (3), bias at 0 [gyro accel]
/// (6), direction of gravity in world, a unit vector (3), camera-IMU time offset t [s] (1), shape S
/// of the gyro, rows one after another (9): reading = (I + S) true rate + bias. It acts on the turn
/// of the states, not on that of the readings, whose noise would bias S (errors in variables).
/// Exact for a constant rate; what S does to dv and dp within one interval is left out.
class ImuFactor final : public ceres::SizedCostFunction<9, 7, 3, 7, 3, 6, 3, 1, 9> {
 public:
  using Vector9 = Eigen::Matrix<double, 9, 1>;
  using Matrix9 = Eigen::Matrix<double, 9, 9>;
  using Matrix96 = Eigen::Matrix<double, 9, 6>;
  using Matrix93 = Eigen::Matrix<double, 9, 3>;

  struct Point {
    lie::SE3d T_world_body0;
    Eigen::Vector3d v0_world;
    lie::SE3d T_world_body1;
    Eigen::Vector3d v1_world;
    Eigen::Matrix<double, 6, 1> bias;  ///< [gyro accel]
    Eigen::Vector3d gravity_direction;
    double time_offset_s;
    Eigen::Matrix3d gyro_shape = Eigen::Matrix3d::Zero();
  };

  /// r and its derivatives; `measurement`: [dR dv dp], rotation on the right of dR.
  struct Linearization {
    Vector9 residual;
    Matrix96 J_pose0;
    Matrix93 J_v0;
    Matrix96 J_pose1;
    Matrix93 J_v1;
    Matrix96 J_bias;
    Matrix93 J_gravity_direction;
    Vector9 J_time_offset;
    Matrix9 J_gyro_shape;
    Matrix9 J_measurement;
  };

  /// `sqrt_information` must be lower triangular (as from pgo::sqrt_information).
  ImuFactor(const ImuMotion& motion, const Matrix9& sqrt_information, double gravity_magnitude);

  static Point point_from_blocks(double const* const* parameters);

  Vector9 residual(const Point& at) const;
  /// The derivatives by gravity, time offset, shape and measurement are left zero unless wanted:
  /// the solver mostly does without.
  Linearization linearize(const Point& at, bool want_measurement = true) const;

  bool Evaluate(double const* const* parameters,
                double* residuals,
                double** jacobians) const override;

 private:
  struct Correction {
    Eigen::Vector3d rotation;  ///< x
    Eigen::Vector3d dv;
    Eigen::Vector3d dp;
  };
  Correction correct(const Point& at) const;

  ImuMotion motion_;
  Eigen::Matrix<double, 6, 1> bias_;
  Matrix9 sqrt_information_;
  double gravity_magnitude_;
};

}  // namespace imslam::pgo
