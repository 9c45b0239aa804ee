#pragma once

#include <Eigen/Core>
#include <optional>

#include "vo_net/pose_layer_system.hpp"

namespace imslam::vo::detail {

/// Solves H x = g with the diagonal scaled to ones; empty if H is not positive definite.
std::optional<Eigen::Matrix<double, 6, 1>> solve_positive(const Eigen::Matrix<double, 6, 6>& H,
                                                          const Eigen::Matrix<double, 6, 1>& g);

struct Spread {
  Eigen::Matrix<double, 6, 6> covariance;
  double factor = 1.0;  ///< covariance = factor * H^-1
};

/// Covariance of the pose as an M-estimator (Huber, "Robust Statistics", 1981, eq. 7.6.2), from a
/// Gauss-Newton system at the minimum. Empty if the pose is not observable.
std::optional<Spread> spread_of(const Problem& problem, const ReducedSystem& system);

}  // namespace imslam::vo::detail
