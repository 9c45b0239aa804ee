#pragma once

#include <ceres/sized_cost_function.h>

#include "pgo/pose_block.hpp"

namespace imslam::pgo {

// The residual families of the published method besides its visual one (RelativePoseFactor with
// information weight^2 I), each with a constant weight w. Source: slam.md, section 2.

/// r = w Log(dR^-1 R0^-1 R1). Blocks: T_world_body0 (7), T_world_body1 (7).
class RotationStepFactor final : public ceres::SizedCostFunction<3, 7, 7> {
 public:
  RotationStepFactor(const lie::SO3d& dR, double weight);
  bool Evaluate(double const* const* parameters,
                double* residuals,
                double** jacobians) const override;

 private:
  lie::SO3d dR_inverse_;
  double weight_;
};

/// r = w (dv_world - (v1 - v0)). Blocks: v0_world (3), v1_world (3).
class VelocityStepFactor final : public ceres::SizedCostFunction<3, 3, 3> {
 public:
  VelocityStepFactor(const Eigen::Vector3d& dv_world, double weight);
  bool Evaluate(double const* const* parameters,
                double* residuals,
                double** jacobians) const override;

 private:
  Eigen::Vector3d dv_world_;
  double weight_;
};

/// r = w ((p1 - p0) - (v0 dt + dp_world)). Blocks: T_world_body0 (7), v0_world (3),
/// T_world_body1 (7).
class TranslationVelocityFactor final : public ceres::SizedCostFunction<3, 7, 3, 7> {
 public:
  TranslationVelocityFactor(const Eigen::Vector3d& dp_world, double dt_s, double weight);
  bool Evaluate(double const* const* parameters,
                double* residuals,
                double** jacobians) const override;

 private:
  Eigen::Vector3d dp_world_;
  double dt_s_;
  double weight_;
};

}  // namespace imslam::pgo
