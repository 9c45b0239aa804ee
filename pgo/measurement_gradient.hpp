#pragma once

#include <Eigen/Core>
#include <vector>

#include "pgo/pose_velocity_graph.hpp"

namespace imslam::pgo {

/// Derivative of the graph's cost with respect to one measurement, states held.
template <int kSize>
struct EdgeGradient {
  /// With respect to the right perturbation of the measurement: [rho theta] of T_body0_body1, or
  /// [dR dv dp] of an IMU motion.
  Eigen::Matrix<double, kSize, 1> motion;
  /// With respect to the covariance as a symmetric matrix:  dL = trace(covariance^T dSigma).
  Eigen::Matrix<double, kSize, kSize> covariance;
};

struct MeasurementGradient {
  std::vector<EdgeGradient<6>> visual;    ///< in the order of graph.visual_edges()
  std::vector<EdgeGradient<9>> inertial;  ///< in the order of graph.inertial_edges()
};

/// The way back to the networks: dL/dz for every measurement z at the graph's present states.
///
///   L = 1/2 sum rho(|W e|^2),   dL/dz = rho' (dr/dz)^T r,   dL/dSigma = -rho'/2 (W^T r)(W^T r)^T
///
/// At the solution dL/dmu = 0, so this is also the derivative of min_mu L(mu, z), the "one step"
/// gradient: exact when solve() has converged and the upper cost is the same L. With
/// `log_determinant`, L gets the term 1/2 log det Sigma per edge, which the covariances of a
/// network need (else they grow without limit).
MeasurementGradient measurement_gradient(const PoseVelocityGraph& graph,
                                         bool log_determinant = false);

}  // namespace imslam::pgo
