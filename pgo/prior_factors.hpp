#pragma once

#include <ceres/sized_cost_function.h>

#include "pgo/pose_block.hpp"

namespace imslam::pgo {

/// Holds a pose: r = W Log(T_prior^-1 T_world_body), 6 dof. Block: T_world_body (7).
class PosePriorFactor final : public ceres::SizedCostFunction<6, 7> {
 public:
  using Matrix6 = Eigen::Matrix<double, 6, 6>;

  PosePriorFactor(const lie::SE3d& T_world_body, const Matrix6& sqrt_information);
  bool Evaluate(double const* const* parameters,
                double* residuals,
                double** jacobians) const override;

 private:
  lie::SE3d T_body_world_;
  Matrix6 sqrt_information_;
};

/// Fixes the 4-dof gauge of a visual-inertial graph: position and heading of one pose.
///
///   r = [(p - p_prior) / sigma_position,   z . Log(R R_prior^T) / sigma_yaw],   z = [0 0 1]
///
/// Roll and pitch stay free: gravity observes them. The residual vanishes at the solution whatever
/// the sigmas, so they do not bend the result. Block: T_world_body (7).
class AnchorFactor final : public ceres::SizedCostFunction<4, 7> {
 public:
  AnchorFactor(const lie::SE3d& T_world_body, double sigma_position_m, double sigma_yaw_rad);
  bool Evaluate(double const* const* parameters,
                double* residuals,
                double** jacobians) const override;

 private:
  lie::SE3d T_world_body_;
  double weight_position_;
  double weight_yaw_;
};

/// Holds a vector: r = (x - x_prior) / sigma, entry by entry. For velocities (also zero-velocity),
/// biases, the direction of gravity (chord length) and the scalar offsets. Block: x (kSize).
template <int kSize>
class VectorPriorFactor final : public ceres::SizedCostFunction<kSize, kSize> {
 public:
  using Vector = Eigen::Matrix<double, kSize, 1>;

  VectorPriorFactor(const Vector& value, const Vector& sigma)
      : value_(value), weight_(sigma.cwiseInverse()) {}

  bool Evaluate(double const* const* parameters,
                double* residuals,
                double** jacobians) const override {
    const Eigen::Map<const Vector> x(parameters[0]);
    Eigen::Map<Vector> r(residuals);
    r = weight_.cwiseProduct(x - value_);
    if (jacobians != nullptr && jacobians[0] != nullptr) {
      constexpr int kLayout = kSize == 1 ? Eigen::ColMajor : Eigen::RowMajor;
      Eigen::Map<Eigen::Matrix<double, kSize, kSize, kLayout>> J(jacobians[0]);
      J = weight_.asDiagonal();
    }
    return r.allFinite();
  }

 private:
  Vector value_;
  Vector weight_;
};

/// Lets a bias drift: r = (b1 - b0) / sigma, sigma = random walk density * sqrt(dt).
/// Blocks: bias at 0 [gyro accel] (6), bias at 1 (6).
class BiasWalkFactor final : public ceres::SizedCostFunction<6, 6, 6> {
 public:
  using Vector6 = Eigen::Matrix<double, 6, 1>;

  /// gyro_random_walk [rad/s^2/sqrt(Hz)], accel_random_walk [m/s^3/sqrt(Hz)], dt_s > 0.
  BiasWalkFactor(double gyro_random_walk, double accel_random_walk, double dt_s);
  bool Evaluate(double const* const* parameters,
                double* residuals,
                double** jacobians) const override;

 private:
  Vector6 weight_;
};

}  // namespace imslam::pgo
