#include "pgo/measurement_gradient.hpp"

#include <numeric>

#include "pgo/edge_linearization.hpp"
#include "pgo/robust_loss.hpp"
#include "slam/base/parallel.hpp"

namespace imslam::pgo {
namespace {

template <int kSize>
EdgeGradient<kSize> edge_gradient(const Eigen::Matrix<double, kSize, 1>& residual,
                                  const Eigen::Matrix<double, kSize, kSize>& J_measurement,
                                  const Eigen::Matrix<double, kSize, kSize>& W,
                                  double kernel_slope,
                                  bool log_determinant) {
  EdgeGradient<kSize> gradient;
  gradient.motion = kernel_slope * (J_measurement.transpose() * residual);
  const Eigen::Matrix<double, kSize, 1> a = W.transpose() * residual;
  gradient.covariance = -0.5 * kernel_slope * a * a.transpose();
  if (log_determinant) gradient.covariance += 0.5 * W.transpose() * W;
  return gradient;
}

/// Residual and sigmas of a prior on [gyro accel].
struct WhitenedBias {
  Eigen::Matrix<double, 6, 1> residual;
  Eigen::Matrix<double, 6, 1> sigma;
};

WhitenedBias whitened(const BiasPrior& prior, const GraphData& data) {
  const ImuBias& bias = data.states[static_cast<std::size_t>(prior.state)].bias;
  WhitenedBias result;
  result.sigma << prior.sigma.gyro, prior.sigma.accel;
  result.residual << bias.gyro - prior.bias.gyro, bias.accel - prior.bias.accel;
  result.residual = result.residual.cwiseQuotient(result.sigma).eval();
  return result;
}

/// 1/2 log det Sigma of a triangular W, W^T W = Sigma^-1.
template <int kSize>
double half_log_determinant(const Eigen::Matrix<double, kSize, kSize>& W) {
  return -W.diagonal().array().log().sum();
}

double sum_of(const std::vector<double>& parts) {
  return std::accumulate(parts.begin(), parts.end(), 0.0);
}

}  // namespace

MeasurementGradient measurement_gradient(const PoseVelocityGraph& graph, bool log_determinant) {
  const GraphData& data = graph.data();
  const auto loss = make_loss(graph.options());
  MeasurementGradient result;
  result.visual.resize(data.visual_edges.size());
  result.inertial.resize(data.inertial_edges.size());

  parallel_for(data.visual_edges.size(), [&](std::size_t i) {
    const VisualEdge& edge = data.visual_edges[i];
    const auto at = linearize(edge, data);
    const double slope = robust_cost(loss.get(), at.residual.squaredNorm()).slope;
    result.visual[i] = edge_gradient<6>(at.residual, at.J_measurement, edge.sqrt_information, slope,
                                        log_determinant);
  });
  parallel_for(data.inertial_edges.size(), [&](std::size_t i) {
    const InertialEdge& edge = data.inertial_edges[i];
    const auto at = linearize(edge, data, graph.options().gravity_magnitude);
    result.inertial[i] = edge_gradient<9>(at.residual, at.J_measurement, edge.sqrt_information, 1.0,
                                          log_determinant);
  });
  for (const BiasPrior& prior : data.bias_priors) {
    const WhitenedBias at = whitened(prior, data);
    BiasPriorGradient gradient;
    gradient.value = -at.residual.cwiseQuotient(at.sigma);
    gradient.log_sigma = -at.residual.cwiseAbs2();
    if (log_determinant) gradient.log_sigma.array() += 1.0;
    result.bias_priors.push_back(gradient);
  }
  return result;
}

NegativeLogLikelihood negative_log_likelihood(const PoseVelocityGraph& graph) {
  const GraphData& data = graph.data();
  const auto loss = make_loss(graph.options());
  NegativeLogLikelihood result;
  double explained = 0.0;  // cost of what has a part of its own
  const auto add = [&explained](double cost, double log_sigma, std::vector<double>& parts) {
    explained += cost;
    parts.push_back(cost + log_sigma);
  };
  for (const VisualEdge& edge : data.visual_edges) {
    const double s = linearize(edge, data).residual.squaredNorm();
    add(0.5 * robust_cost(loss.get(), s).value, half_log_determinant<6>(edge.sqrt_information),
        result.visual);
  }
  for (const InertialEdge& edge : data.inertial_edges) {
    const auto at = linearize(edge, data, graph.options().gravity_magnitude);
    add(0.5 * at.residual.squaredNorm(), half_log_determinant<9>(edge.sqrt_information),
        result.inertial);
  }
  for (const BiasPrior& prior : data.bias_priors) {
    const WhitenedBias at = whitened(prior, data);
    add(0.5 * at.residual.squaredNorm(), at.sigma.array().log().sum(), result.bias_priors);
  }
  result.rest = graph.cost() - explained;
  return result;
}

double NegativeLogLikelihood::total() const {
  return sum_of(visual) + sum_of(inertial) + sum_of(bias_priors) + rest;
}

}  // namespace imslam::pgo
