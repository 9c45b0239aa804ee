#include "pgo/edge_likelihood.hpp"

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <cmath>

#include "pgo/graph_problem.hpp"
#include "pgo/whitening.hpp"

namespace imslam::pgo {
namespace {

constexpr double kFullLeverage = 0.999;  // beyond it nothing else measures that direction
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

template <int kSize>
EdgeLikelihood<kSize> likelihood(const Eigen::Matrix<double, kSize, 1>& residual,
                                 const Eigen::Matrix<double, kSize, kSize>& J_measurement,
                                 const Eigen::Matrix<double, kSize, kSize>& W,
                                 const Eigen::Matrix<double, kSize, kSize>& spread,
                                 const ceres::LossFunction* loss) {
  using Matrix = Eigen::Matrix<double, kSize, kSize>;
  const Kernel kernel = kernel_at(loss, residual.squaredNorm());
  const Matrix information = W.transpose() * W;
  const Eigen::Matrix<double, kSize, 1> a = W.transpose() * residual;
  EdgeLikelihood<kSize> result;
  result.nll = 0.5 * (kernel.value + (information * spread).trace() + log_det_covariance(W));
  result.gradient.motion = kernel.slope * (J_measurement.transpose() * residual);
  result.gradient.covariance =
      0.5 * (information - kernel.slope * a * a.transpose() - information * spread * information);
  return result;
}

RelativePoseFactor::Linearization at_solution(const GraphData& data,
                                              const VisualEdge& edge,
                                              const RelativeMotion& motion,
                                              const Eigen::Matrix<double, 6, 6>& W) {
  return RelativePoseFactor(motion, W).linearize(
      data.states[static_cast<std::size_t>(edge.from)].nav.T_world_body,
      data.states[static_cast<std::size_t>(edge.to)].nav.T_world_body,
      data.globals.disparity_offset, data.globals.focal_error);
}

ImuFactor::Linearization at_solution(const PoseVelocityGraph& graph,
                                     const InertialEdge& edge,
                                     const ImuMotion& motion,
                                     const Eigen::Matrix<double, 9, 9>& W) {
  const GraphData& data = graph.data();
  const State& from = data.states[static_cast<std::size_t>(edge.from)];
  const State& to = data.states[static_cast<std::size_t>(edge.to)];
  ImuFactor::Point point{from.nav.T_world_body,
                         from.nav.v_world,
                         to.nav.T_world_body,
                         to.nav.v_world,
                         {},
                         data.globals.gravity_direction,
                         data.globals.time_offset_s};
  point.bias << from.bias.gyro, from.bias.accel;
  return ImuFactor(motion, W, graph.options().gravity_magnitude).linearize(point);
}

template <int kSize>
double left_out(const Eigen::Matrix<double, kSize, 1>& r,
                const Eigen::Matrix<double, kSize, kSize>& W,
                const Eigen::Matrix<double, kSize, kSize>& spread) {
  using Matrix = Eigen::Matrix<double, kSize, kSize>;
  const Matrix leverage = W * spread * W.transpose();
  const Eigen::SelfAdjointEigenSolver<Matrix> eigen(0.5 * (leverage + leverage.transpose()));
  double square = 0.0;
  double log_det = log_det_covariance(W);
  int dimensions = 0;
  for (int k = 0; k < kSize; ++k) {
    const double share = eigen.eigenvalues()[k];
    if (share > kFullLeverage) continue;
    const double along = eigen.eigenvectors().col(k).dot(r);
    square += along * along / (1.0 - share);
    log_det -= std::log(1.0 - share);
    ++dimensions;
  }
  const double limit = kRobust * dimensions;
  if (square > limit) square = 2.0 * std::sqrt(limit * square) - limit;
  return 0.5 * (square + log_det);
}

}  // namespace

EdgeLikelihood<6> visual_likelihood(const PoseVelocityGraph& graph,
                                    std::size_t edge,
                                    const RelativeMotion& motion,
                                    const Eigen::Matrix<double, 6, 6>& spread) {
  const auto W = sqrt_information(motion.covariance);
  if (!W) {
    return {0.0, {Eigen::Matrix<double, 6, 1>::Zero(), Eigen::Matrix<double, 6, 6>::Zero()}};
  }
  const auto at = at_solution(graph.data(), graph.visual_edges().at(edge), motion, *W);
  return likelihood<6>(at.residual, at.J_measurement, *W, spread, make_loss(graph.options()).get());
}

EdgeLikelihood<9> inertial_likelihood(const PoseVelocityGraph& graph,
                                      std::size_t edge,
                                      const ImuMotion& motion,
                                      const Eigen::Matrix<double, 9, 9>& spread) {
  const auto W = sqrt_information(motion.covariance);
  if (!W) {
    return {0.0, {Eigen::Matrix<double, 9, 1>::Zero(), Eigen::Matrix<double, 9, 9>::Zero()}};
  }
  const auto at = at_solution(graph, graph.inertial_edges().at(edge), motion, *W);
  return likelihood<9>(at.residual, at.J_measurement, *W, spread, nullptr);
}

double left_out_nll(const PoseVelocityGraph& graph,
                    const PosteriorSpread& spread,
                    std::size_t visual_edge) {
  const VisualEdge& edge = graph.visual_edges().at(visual_edge);
  const auto at = at_solution(graph.data(), edge, edge.motion, edge.sqrt_information);
  return left_out<6>(at.residual, edge.sqrt_information, spread.visual.at(visual_edge));
}

double left_out_nll_inertial(const PoseVelocityGraph& graph,
                             const PosteriorSpread& spread,
                             std::size_t inertial_edge) {
  const InertialEdge& edge = graph.inertial_edges().at(inertial_edge);
  const auto at = at_solution(graph, edge, edge.motion, edge.sqrt_information);
  return left_out<9>(at.residual, edge.sqrt_information, spread.inertial.at(inertial_edge));
}

}  // namespace imslam::pgo
