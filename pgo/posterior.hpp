#pragma once

#include <Eigen/Core>
#include <memory>
#include <optional>
#include <vector>

#include "pgo/pose_velocity_graph.hpp"

namespace imslam::pgo {

/// How far a residual may still lie from where the solution puts it, because the states are only
/// known with the covariance P = H^-1:   S = J P J^T, J the residual's derivative by the states.
///
/// Unwhitened, in the units of the edge's covariance. The share of S in S + Sigma, the leverage,
/// says how much of the states the edge itself decides.
struct PosteriorSpread {
  std::vector<Eigen::Matrix<double, 6, 6>> visual;    ///< in the order of the graph's edges
  std::vector<Eigen::Matrix<double, 9, 9>> inertial;  ///< likewise
};

/// The Gaussian around the solution of a graph: robust kernels count as their weights.
class Posterior {
 public:
  /// Empty if the graph does not determine its states.
  static std::optional<Posterior> of(const PoseVelocityGraph& graph);
  Posterior(Posterior&&) noexcept;
  Posterior& operator=(Posterior&&) noexcept;
  ~Posterior();

  const PosteriorSpread& spread() const;
  /// Joint covariance of two states, tangent [rho theta nu] of the one and then of the other.
  Eigen::Matrix<double, 18, 18> joint(int state0, int state1) const;
  /// Of the bias at a state, [gyro accel].
  Eigen::Matrix<double, 6, 6> bias(int state) const;

 private:
  class System;
  explicit Posterior(std::unique_ptr<System> system);
  std::unique_ptr<System> system_;
};

}  // namespace imslam::pgo
