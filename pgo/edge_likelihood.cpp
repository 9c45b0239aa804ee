#include "pgo/edge_likelihood.hpp"

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>

#include "pgo/edge_linearization.hpp"
#include "pgo/graph_problem.hpp"
#include "pgo/whitening.hpp"

namespace imslam::pgo {
namespace {

constexpr double kFullLeverage = 0.999;  // beyond it nothing else measures that direction
constexpr double kLeastWeight = 1e-6;    // of an outlier
constexpr double kRobust = 16.0;         // [1] of the square per dimension

struct Kernel {
  double value;  ///< rho(s)
  double slope;  ///< rho'(s)
};

Kernel kernel_at(const ceres::LossFunction* loss, double s) {
  if (loss == nullptr) return {s, 1.0};
  double rho[3];
  loss->Evaluate(s, rho);
  return {rho[0], rho[1]};
}

double log_det_covariance(const Eigen::Ref<const Eigen::MatrixXd>& W) {
  return -2.0 * W.diagonal().array().log().sum();
}

/// r = W e with W of the measurement's own covariance; J_measurement is whitened alike.
template <int kSize, typename KernelAt>
EdgeLikelihood<kSize> likelihood(const Eigen::Matrix<double, kSize, 1>& residual,
                                 const Eigen::Matrix<double, kSize, kSize>& J_measurement,
                                 const Eigen::Matrix<double, kSize, kSize>& W,
                                 const Foretold<kSize>& others,
                                 const KernelAt& kernel_at_square) {
  using Matrix = Eigen::Matrix<double, kSize, kSize>;
  using Vector = Eigen::Matrix<double, kSize, 1>;
  // In units of W: u = r + W shift, C = I + W S W^T.
  const Vector u = residual + W * others.shift;
  const Matrix C = Matrix::Identity() + W * others.spread * W.transpose();
  const Eigen::LLT<Matrix> llt(C);
  const Vector a = llt.solve(u);
  const Kernel kernel = kernel_at_square(u.dot(a));
  const Matrix L = llt.matrixL();
  const double log_det = 2.0 * L.diagonal().array().log().sum() + log_det_covariance(W);
  EdgeLikelihood<kSize> result;
  result.nll = 0.5 * (kernel.value + log_det);
  result.gradient.motion = kernel.slope * (J_measurement.transpose() * a);
  const Vector back = W.transpose() * a;
  result.gradient.covariance =
      0.5 * (W.transpose() * llt.solve(W) - kernel.slope * back * back.transpose());
  return result;
}

template <int kSize>
Foretold<kSize> foretold(const Eigen::Matrix<double, kSize, 1>& r,
                         const Eigen::Matrix<double, kSize, kSize>& W,
                         const Eigen::Matrix<double, kSize, kSize>& leverage,
                         double weight) {
  using Matrix = Eigen::Matrix<double, kSize, kSize>;
  using Vector = Eigen::Matrix<double, kSize, 1>;
  const Eigen::SelfAdjointEigenSolver<Matrix> eigen(0.5 * (leverage + leverage.transpose()));
  const Vector share = eigen.eigenvalues().cwiseMax(0.0).cwiseMin(kFullLeverage);
  const Vector odds = share.array() / (1.0 - share.array());
  const Matrix unwhitened =
      W.template triangularView<Eigen::Lower>().solve(Matrix(eigen.eigenvectors()));
  Foretold<kSize> result;
  result.shift = unwhitened * odds.asDiagonal() * (eigen.eigenvectors().transpose() * r);
  result.spread = unwhitened * odds.asDiagonal() * unwhitened.transpose() / weight;
  return result;
}

Kernel robust(double square) {
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
  const double weight = kernel_at(loss.get(), at.residual.squaredNorm()).slope;
  return foretold<6>(at.residual, e.sqrt_information, posterior.visual.at(edge),
                     std::max(weight, kLeastWeight));
}

Foretold<9> foretold_inertial(const PoseVelocityGraph& graph,
                              const ResidualPosterior& posterior,
                              std::size_t edge) {
  const InertialEdge& e = graph.inertial_edges().at(edge);
  const auto at = linearize(e, graph.data(), graph.options().gravity_magnitude);
  return foretold<9>(at.residual, e.sqrt_information, posterior.inertial.at(edge), 1.0);
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
  return likelihood<6>(at.residual, at.J_measurement, *W, others,
                       [&](double square) { return kernel_at(loss.get(), square); });
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
  return likelihood<9>(at.residual, at.J_measurement, *W, others, robust);
}

}  // namespace imslam::pgo
