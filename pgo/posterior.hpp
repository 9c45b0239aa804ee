#pragma once

#include <Eigen/Core>
#include <memory>
#include <optional>

#include "pgo/pose_velocity_graph.hpp"
#include "pgo/residual_posterior.hpp"

namespace imslam::pgo {

/// The Gaussian around the solution of a graph, covariance P = (J^T J)^-1: robust kernels count as
/// their weights.
class Posterior {
 public:
  /// Empty if the graph does not determine its states.
  static std::optional<Posterior> of(const PoseVelocityGraph& graph);
  Posterior(Posterior&&) noexcept;
  Posterior& operator=(Posterior&&) noexcept;
  ~Posterior();

  /// How much of each residual the states decide.
  const ResidualPosterior& residuals() const;
  /// Joint covariance of two states, tangent [rho theta nu] of the one and then of the other.
  Eigen::Matrix<double, 18, 18> joint(int state0, int state1) const;

 private:
  class System;
  explicit Posterior(std::unique_ptr<System> system);
  std::unique_ptr<System> system_;
};

}  // namespace imslam::pgo
