#pragma once

#include <Eigen/Core>
#include <optional>
#include <vector>

#include "pgo/measurement_gradient.hpp"

namespace imslam::pgo {

/// How far the states could move each whitened residual, all measurements given: J_e P J_e^T with
/// P = (J^T J)^-1, robust kernels counted as their weights.
///
/// States that follow the noise leave less of it: E[r r^T] = I - J_e P J_e^T. A likelihood at the
/// best states therefore calls for sigmas that are too small, and for none at all where an edge can
/// be met exactly. With the states integrated out (Laplace) it gets the term
///
///   1/2 log det J^T J        d/dSigma_e = -1/2 W^T (J_e P J_e^T) W        J held
///
/// and a covariance is at rest where it equals  r r^T + J_e P J_e^T  in units of itself: what is
/// left and what the states have taken.
struct ResidualPosterior {
  double half_log_determinant = 0.0;  ///< 1/2 log det J^T J
  std::vector<Eigen::Matrix<double, 6, 6>> visual;
  std::vector<Eigen::Matrix<double, 9, 9>> inertial;
  std::vector<Eigen::Matrix<double, 6, 1>> bias_priors;  ///< the diagonals

  /// Adds the term's slope by the covariances and the log sigmas.
  void add_to(const GraphData& data, MeasurementGradient& gradient) const;
};

/// Empty: the graph does not determine its states.
std::optional<ResidualPosterior> residual_posterior(const PoseVelocityGraph& graph);

}  // namespace imslam::pgo
