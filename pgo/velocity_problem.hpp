#pragma once

#include <Eigen/Core>
#include <vector>

#include "pgo/initialization.hpp"

namespace imslam::pgo {

/// Linear least squares in [gravity parameters (3), accel bias (3), v_0, v_1, ...], body 0's frame:
/// the second part of initialize(). Rotations are taken from the gyro at the given bias, or from
/// vision where the IMU is silent. The gravity vector is g = g0 + G u: G = I to find it, or the
/// tangent plane of the sphere (then the third parameter is held at zero).
///
/// Refers to the motions, which must outlive it.
class VelocityProblem {
 public:
  VelocityProblem(const std::vector<RelativeMotion>& visual,
                  const std::vector<ImuMotion>& inertial,
                  const Eigen::Vector3d& gyro_bias,
                  const InitializationOptions& options);

  struct Solution {
    Eigen::Vector3d gravity;
    Eigen::Vector3d accel_bias;
    std::vector<Eigen::Vector3d> velocities;
    Eigen::Matrix3d parameter_covariance;  ///< of u
  };

  /// Three times: all weights one, then with Huber weights at the solution before. False: the data
  /// do not determine it.
  bool solve(const Eigen::Vector3d& g0,
             const Eigen::Matrix3d& G,
             bool hold_third,
             Solution& solution) const;

  const std::vector<lie::SO3d>& rotations() const { return R_body0_body_; }

 private:
  class Rows;

  void chain_rotations();
  void add_interval(std::size_t i,
                    const Eigen::Vector3d& g0,
                    const Eigen::Matrix3d& G,
                    const Eigen::VectorXd* at,
                    Rows& rows) const;
  bool solve_once(const Eigen::Vector3d& g0,
                  const Eigen::Matrix3d& G,
                  bool hold_third,
                  const Eigen::VectorXd* at,
                  Eigen::VectorXd& x,
                  Solution& solution) const;
  Eigen::Vector3d integrated_accel_bias() const;

  const std::vector<RelativeMotion>& visual_;
  const std::vector<ImuMotion>& inertial_;
  Eigen::Vector3d gyro_bias_;
  InitializationOptions options_;
  std::vector<lie::SO3d> R_body0_body_;
};

}  // namespace imslam::pgo
