#pragma once

#include <Eigen/Core>
#include <string>
#include <vector>

#include "pgo/graph_data.hpp"
#include "pgo/measurement_gradient.hpp"

namespace imslam::system {

/// All measurements of a graph, with how sure they are, as one vector z about those it was built
/// with (index 0):
///
///   visual edge    27   tau, S     T = T_0 Exp(tau)                      Sigma = W_0^-1 S W_0^-T
///   inertial edge  54   x, S       dR = dR_0 Exp(x_R), dv_0 + x_v, dp_0 + x_p   Sigma alike
///   bias prior     12   b, log s   value [gyro accel] [rad/s, m/s^2], log of the sigmas
///
/// W_0 is the edge's square root of information. S, its covariance in units of the first one, is
/// given by its lower triangle, row by row: (0,0), (1,0), (1,1), ... At the start tau = 0, S = I.
class MeasurementCoordinates {
 public:
  using Vector = Eigen::VectorXd;
  static constexpr Eigen::Index kVisual = 6 + 21;
  static constexpr Eigen::Index kInertial = 9 + 45;
  static constexpr Eigen::Index kBiasPrior = 6 + 6;

  explicit MeasurementCoordinates(const pgo::GraphData& data);

  /// First number of each; those of a kind stand side by side in the order of the graph.
  Eigen::Index visual(std::size_t edge) const;
  Eigen::Index inertial(std::size_t edge) const;
  Eigen::Index bias_prior(std::size_t prior) const;
  Eigen::Index size() const { return bias_prior(bias_priors_.size()); }

  /// z of the graph that this was built from.
  Vector origin() const;

  /// Sets the measurements of a graph with the same edges. Returns what is wrong with z: then
  /// nothing is set. Empty: fine.
  std::string apply(const Vector& z, pgo::GraphData& data) const;

  /// dL/dz from the slopes by the measurements at z.
  Vector pull_back(const Vector& z, const pgo::MeasurementGradient& gradient) const;

  /// z of one edge for what a network says about it; only motion and covariance are read.
  Vector visual_numbers(std::size_t edge, const RelativeMotion& motion) const;
  Vector inertial_numbers(std::size_t edge, const ImuMotion& motion) const;

  /// The way back of visual_numbers() and inertial_numbers(): from dz, all of it, to the slopes by
  /// motion and covariance.
  pgo::EdgeGradient<6> visual_gradient(std::size_t edge, const Vector& z, const Vector& dz) const;
  pgo::EdgeGradient<9> inertial_gradient(std::size_t edge, const Vector& z, const Vector& dz) const;

 private:
  std::vector<pgo::VisualEdge> visual_;
  std::vector<pgo::InertialEdge> inertial_;
  std::vector<pgo::BiasPrior> bias_priors_;
};

}  // namespace imslam::system
