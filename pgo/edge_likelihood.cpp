#include "pgo/edge_likelihood.hpp"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <functional>

#include "pgo/edge_linearization.hpp"
#include "pgo/robust_loss.hpp"
#include "pgo/symmetric_eigen.hpp"
#include "pgo/whitening.hpp"

namespace imslam::pgo {
namespace {

using Eigen::MatrixXd;
using Eigen::VectorXd;

constexpr double kFullLeverage = 0.999;  // beyond it nothing else measures that direction
constexpr double kLeastWeight = 1e-6;    // of an outlier
constexpr double kRobust = 16.0;         // [1] of the square per dimension

/// Sizes as in EdgeLikelihood and Foretold, known at run time: for fixed ones a compiler takes half
/// a minute.
struct Likelihood {
  double nll;
  VectorXd motion;
  MatrixXd covariance;
};

struct Others {
  VectorXd shift;
  MatrixXd spread;
};

/// r = W e with W of the measurement's own covariance; J_measurement is whitened alike.
Likelihood likelihood(const VectorXd& residual,
                      const MatrixXd& J_measurement,
                      const MatrixXd& W,
                      const Others& others,
                      const std::function<RobustCost(double)>& cost_of_square) {
  // In units of W: u = r + W shift, C = I + W S W^T.
  const VectorXd u = residual + W * others.shift;
  MatrixXd C = W * others.spread * W.transpose();
  C.diagonal().array() += 1.0;
  const Eigen::LLT<MatrixXd> llt(C);
  const VectorXd a = llt.solve(u);
  const RobustCost kernel = cost_of_square(u.dot(a));
  const double log_det =
      2.0 * llt.matrixLLT().diagonal().array().log().sum() - 2.0 * W.diagonal().array().log().sum();
  const VectorXd back = W.transpose() * a;
  MatrixXd slope = W.transpose() * llt.solve(W);
  slope -= kernel.slope * back * back.transpose();
  return {0.5 * (kernel.value + log_det), kernel.slope * (J_measurement.transpose() * a),
          0.5 * slope};
}

template <int kSize>
EdgeLikelihood<kSize> sized(const Likelihood& l) {
  return {l.nll, {l.motion, l.covariance}};
}

Others foretold(const VectorXd& r, const MatrixXd& W, const MatrixXd& leverage, double weight) {
  const SymmetricEigen eigen = symmetric_eigen(0.5 * (leverage + leverage.transpose()));
  const VectorXd share = eigen.values.cwiseMax(0.0).cwiseMin(kFullLeverage);
  const VectorXd odds = share.array() / (1.0 - share.array());
  const MatrixXd unwhitened = W.triangularView<Eigen::Lower>().solve(eigen.vectors);
  const MatrixXd scaled = unwhitened * odds.asDiagonal();
  return {scaled * (eigen.vectors.transpose() * r), scaled * unwhitened.transpose() / weight};
}

RobustCost robust(double square) {
  const double limit = kRobust * 9.0;
  if (square <= limit) return {square, 1.0};
  return {2.0 * std::sqrt(limit * square) - limit, std::sqrt(limit / square)};
}

template <int kSize>
EdgeLikelihood<kSize> nothing() {
  return {0.0,
          {Eigen::Matrix<double, kSize, 1>::Zero(), Eigen::Matrix<double, kSize, kSize>::Zero()}};
}

}  // namespace

Foretold<6> foretold_visual(const PoseVelocityGraph& graph,
                            const ResidualPosterior& posterior,
                            std::size_t edge) {
  const VisualEdge& e = graph.visual_edges().at(edge);
  const auto at = linearize(e, graph.data());
  const auto loss = make_loss(graph.options());
  const double weight = robust_cost(loss.get(), at.residual.squaredNorm()).slope;
  const Others others = foretold(at.residual, e.sqrt_information, posterior.visual.at(edge),
                                 std::max(weight, kLeastWeight));
  return {others.shift, others.spread};
}

Foretold<9> foretold_inertial(const PoseVelocityGraph& graph,
                              const ResidualPosterior& posterior,
                              std::size_t edge) {
  const InertialEdge& e = graph.inertial_edges().at(edge);
  const auto at = linearize(e, graph.data(), graph.options().gravity_magnitude);
  const Others others = foretold(at.residual, e.sqrt_information, posterior.inertial.at(edge), 1.0);
  return {others.shift, others.spread};
}

EdgeLikelihood<6> visual_likelihood(const PoseVelocityGraph& graph,
                                    std::size_t edge,
                                    const RelativeMotion& motion,
                                    const Foretold<6>& others) {
  const auto W = sqrt_information(motion.covariance);
  if (!W) return nothing<6>();
  const VisualEdge& held = graph.visual_edges().at(edge);
  const auto at = linearize(VisualEdge{held.from, held.to, motion, *W}, graph.data());
  const auto loss = make_loss(graph.options());
  return sized<6>(likelihood(at.residual, at.J_measurement, *W, {others.shift, others.spread},
                             [&](double square) { return robust_cost(loss.get(), square); }));
}

EdgeLikelihood<9> inertial_likelihood(const PoseVelocityGraph& graph,
                                      std::size_t edge,
                                      const ImuMotion& motion,
                                      const Foretold<9>& others) {
  const auto W = sqrt_information(motion.covariance);
  if (!W) return nothing<9>();
  const InertialEdge& held = graph.inertial_edges().at(edge);
  const auto at = linearize(InertialEdge{held.from, held.to, motion, *W}, graph.data(),
                            graph.options().gravity_magnitude);
  return sized<9>(
      likelihood(at.residual, at.J_measurement, *W, {others.shift, others.spread}, robust));
}

}  // namespace imslam::pgo
