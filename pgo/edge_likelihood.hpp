#pragma once

#include "pgo/measurement_gradient.hpp"
#include "pgo/residual_posterior.hpp"

namespace imslam::pgo {

/// A negative log-likelihood of one measurement, without the constant of 2 pi, and its slopes.
template <int kSize>
struct EdgeLikelihood {
  double nll = 0.0;
  EdgeGradient<kSize> gradient;
};

/// What all the others say about one measurement: where it should lie and how surely, as a
/// residual at the graph's solution. Had without solving again: with r = W e the whitened residual
/// of the measurement that took part in the solution, w its robust weight and V diag(l) V^T its
/// leverage (ResidualPosterior),
///
///   S_others = W^-1 V diag(l / (1 - l)) V^T W^-T / w      shift = W^-1 V diag(l / (1 - l)) V^T r
///
/// e + shift is the residual against the states as they would be without the measurement, whose
/// spread is S_others. Directions that nothing else measures (l = 1) get a spread that says so.
/// Source of the identity: Cook and Weisberg, "Residuals and Influence in Regression", 1982.
template <int kSize>
struct Foretold {
  Eigen::Matrix<double, kSize, 1> shift = Eigen::Matrix<double, kSize, 1>::Zero();
  Eigen::Matrix<double, kSize, kSize> spread = Eigen::Matrix<double, kSize, kSize>::Zero();
};

Foretold<6> foretold_visual(const PoseVelocityGraph& graph,
                            const ResidualPosterior& posterior,
                            std::size_t edge);
Foretold<9> foretold_inertial(const PoseVelocityGraph& graph,
                              const ResidualPosterior& posterior,
                              std::size_t edge);

/// Likelihood of `motion` in the place of a visual edge's measurement, the states held:
///
///   u = e(motion) + shift     C = Sigma + S_others     l = 1/2 rho(u^T C^-1 u) + 1/2 log det C
///
/// Without others (shift = 0, S_others = 0) it is the graph's own cost of the edge with its
/// normalisation, so that the sum over the edges is the joint likelihood. But under that one a
/// covariance that shrinks takes the states along, and a network that repeats what the states say
/// confirms itself: the sum falls without limit as one Sigma -> 0. Held against the others alone a
/// measurement can do neither.
///
/// rho is the graph's kernel; of inertial edges robust_square (16 per dimension). Zero likelihood
/// and gradient if the covariance of `motion` is not positive.
EdgeLikelihood<6> visual_likelihood(const PoseVelocityGraph& graph,
                                    std::size_t edge,
                                    const RelativeMotion& motion,
                                    const Foretold<6>& others = {});
EdgeLikelihood<9> inertial_likelihood(const PoseVelocityGraph& graph,
                                      std::size_t edge,
                                      const ImuMotion& motion,
                                      const Foretold<9>& others = {});

}  // namespace imslam::pgo
