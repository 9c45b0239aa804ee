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

/// The same for a bias prior, [gyro accel].
struct BiasPriorGradient {
  Eigen::Matrix<double, 6, 1> value;
  Eigen::Matrix<double, 6, 1> log_sigma;
};

struct MeasurementGradient {
  std::vector<EdgeGradient<6>> visual;    ///< in the order of graph.visual_edges()
  std::vector<EdgeGradient<9>> inertial;  ///< in the order of graph.inertial_edges()
  std::vector<BiasPriorGradient> bias_priors;
};

/// The way back to the networks: dL/dz for every measurement z at the graph's present states.
///
///   L = 1/2 sum rho(|W e|^2),   dL/dz = rho' (dr/dz)^T r,   dL/dSigma = -rho'/2 (W^T r)(W^T r)^T
///
/// At the solution dL/dmu = 0, so this is also the derivative of min_mu L(mu, z), the "one step"
/// gradient: exact when solve() has converged and the upper cost is the same L. With
/// `log_determinant`, L gets the term 1/2 log det Sigma per edge and log sigma per entry of a bias
/// prior, which the covariances of a network need (else they grow without limit).
MeasurementGradient measurement_gradient(const PoseVelocityGraph& graph,
                                         bool log_determinant = false);

/// What each part of the graph adds to the negative log-likelihood of its measurements, constants
/// left out:  1/2 rho(|W e|^2) + 1/2 log det Sigma  of an edge,  1/2 r^2 + log sigma  of each entry
/// of a bias prior. The other factors have fixed sigmas: `rest` is their cost.
struct NegativeLogLikelihood {
  std::vector<double> visual;    ///< in the order of graph.visual_edges()
  std::vector<double> inertial;  ///< in the order of graph.inertial_edges()
  std::vector<double> bias_priors;
  double rest = 0.0;

  double total() const;
};

NegativeLogLikelihood negative_log_likelihood(const PoseVelocityGraph& graph);

}  // namespace imslam::pgo
