#pragma once

#include <Eigen/Core>
#include <vector>

#include "slam/lie/se3.hpp"

namespace imslam::simulation {

/// Everything that an ideal inertial sensor and an ideal camera need to know at one instant.
struct MotionState {
  lie::SE3d T_world_body;
  Eigen::Vector3d v_world = Eigen::Vector3d::Zero();     ///< [m/s]
  Eigen::Vector3d a_world = Eigen::Vector3d::Zero();     ///< [m/s^2], without gravity
  Eigen::Vector3d omega_body = Eigen::Vector3d::Zero();  ///< [rad/s]
  Eigen::Vector3d alpha_body = Eigen::Vector3d::Zero();  ///< [rad/s^2]
};

/// A motion with four continuous derivatives: uniform quintic B-splines over R^3 and, in cumulative
/// form, over SO(3), all derivatives in closed form.
///
///   p(t) = sum_j b_j(u) p_{i+j},     R(t) = R_i prod_j Exp(B_j(u) log(R_{i+j-1}^T R_{i+j}))
///
/// Control pose k belongs to the time (k - 2) knot_dt_s; the spline is defined on
/// [0, duration_s()]. Equal control poses give exact rest; control points on a parabola give
/// exactly constant acceleration.
/// Source: Sommer et al., "Efficient derivative computation for cumulative B-splines on Lie
/// groups", CVPR 2020.
class MotionSpline {
 public:
  /// At least 6 control poses.
  MotionSpline(double knot_dt_s, std::vector<lie::SE3d> control_poses);

  MotionState at(double time_s) const;  ///< clamped to the ends
  double duration_s() const { return duration_s_; }

  /// Control poses that are needed to cover `duration_s`.
  static std::size_t control_count(double knot_dt_s, double duration_s);
  static double control_time(double knot_dt_s, std::size_t k) {
    return (static_cast<double>(k) - 2.0) * knot_dt_s;
  }

 private:
  double knot_dt_s_;
  double duration_s_;
  std::vector<lie::SE3d> control_poses_;
  std::vector<Eigen::Vector3d> steps_;  ///< log(R_{k}^T R_{k+1})
};

}  // namespace imslam::simulation
