#pragma once

#include "pgo/measurement_gradient.hpp"
#include "pgo/posterior.hpp"

namespace imslam::pgo {

/// What the graph says about one measurement: its negative log-likelihood at the solution, the
/// states known only with a spread S (see PosteriorSpread), and the slopes of that.
///
///   e = residual, unwhitened      l = 1/2 rho(e^T Sigma^-1 e) + 1/2 tr(Sigma^-1 S)
///                                     + 1/2 log det Sigma
///
/// With S = 0 this is the graph's own cost of the edge and its normalisation. But a covariance that
/// shrinks takes the states along until nothing is left of e: the sum over all edges of the graph
/// falls without limit as one Sigma -> 0. S is what the evidence, the likelihood of the
/// measurements with the states integrated out (Laplace), adds: by Fisher's identity its gradient
/// is that of the expected likelihood, E[e e^T] = e e^T + S. S counts as a constant.
template <int kSize>
struct EdgeLikelihood {
  double nll = 0.0;  ///< without the constant of 2 pi
  EdgeGradient<kSize> gradient;
};

/// Of visual edge number `edge` with `motion` in the place of its measurement. `rho` is the graph's
/// kernel. Zero likelihood and gradient if the covariance of `motion` is not positive.
EdgeLikelihood<6> visual_likelihood(const PoseVelocityGraph& graph,
                                    std::size_t edge,
                                    const RelativeMotion& motion,
                                    const Eigen::Matrix<double, 6, 6>& spread);

/// Of inertial edge number `edge` likewise; no kernel.
EdgeLikelihood<9> inertial_likelihood(const PoseVelocityGraph& graph,
                                      std::size_t edge,
                                      const ImuMotion& motion,
                                      const Eigen::Matrix<double, 9, 9>& spread);

/// How well all others foretell a measurement that took part in the solution: its negative
/// log-likelihood if it had been left out, without solving again,
///
///   l = 1/2 r^T (I - Lambda)^-1 r - 1/2 log det(I - Lambda) + 1/2 log det Sigma
///
/// r = W e, leverage Lambda = W S W^T. The square counts as robust_square beyond 16 per dimension,
/// so that one edge does not decide. Directions that nothing else measures (leverage 1) do not
/// count. Source of the identity: Cook and Weisberg, "Residuals and Influence in Regression", 1982.
double left_out_nll(const PoseVelocityGraph& graph,
                    const PosteriorSpread& spread,
                    std::size_t visual_edge);
double left_out_nll_inertial(const PoseVelocityGraph& graph,
                             const PosteriorSpread& spread,
                             std::size_t inertial_edge);

}  // namespace imslam::pgo
