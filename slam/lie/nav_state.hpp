#pragma once

#include <Eigen/Core>

#include "slam/lie/se3.hpp"

namespace imslam::lie {

/// Pose and velocity of the body: what the pose-velocity graph estimates at each frame.
///
///   tangent   [rho theta nu] in [m, rad, m/s];  plus: {T Exp([rho theta]), v + nu}
struct NavState {
  using Tangent = Eigen::Matrix<double, 9, 1>;

  SE3d T_world_body;
  Eigen::Vector3d v_world = Eigen::Vector3d::Zero();  ///< [m/s]

  NavState plus(const Tangent& tau) const {
    return {T_world_body * SE3d::exp(tau.head<6>()), v_world + tau.tail<3>()};
  }

  /// The tau with  from.plus(tau) = *this.
  Tangent minus(const NavState& from) const {
    Tangent tau;
    tau << (from.T_world_body.inverse() * T_world_body).log(), v_world - from.v_world;
    return tau;
  }
};

}  // namespace imslam::lie
