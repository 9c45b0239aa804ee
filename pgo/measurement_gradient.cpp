#include "pgo/measurement_gradient.hpp"

#include "pgo/graph_problem.hpp"
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

/// rho'(s)
double slope(const ceres::LossFunction* loss, double s) {
  if (loss == nullptr) return 1.0;
  double rho[3];
  loss->Evaluate(s, rho);
  return rho[1];
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
    const RelativePoseFactor factor(edge.motion, edge.sqrt_information);
    const auto at =
        factor.linearize(data.states[static_cast<std::size_t>(edge.from)].nav.T_world_body,
                         data.states[static_cast<std::size_t>(edge.to)].nav.T_world_body,
                         data.globals.disparity_offset, data.globals.focal_error);
    result.visual[i] =
        edge_gradient<6>(at.residual, at.J_measurement, edge.sqrt_information,
                         slope(loss.get(), at.residual.squaredNorm()), log_determinant);
  });
  parallel_for(data.inertial_edges.size(), [&](std::size_t i) {
    const InertialEdge& edge = data.inertial_edges[i];
    const State& from = data.states[static_cast<std::size_t>(edge.from)];
    const State& to = data.states[static_cast<std::size_t>(edge.to)];
    const ImuFactor factor(edge.motion, edge.sqrt_information, graph.options().gravity_magnitude);
    ImuFactor::Point point{from.nav.T_world_body,
                           from.nav.v_world,
                           to.nav.T_world_body,
                           to.nav.v_world,
                           {},
                           data.globals.gravity_direction,
                           data.globals.time_offset_s};
    point.bias << from.bias.gyro, from.bias.accel;
    const auto at = factor.linearize(point);
    result.inertial[i] = edge_gradient<9>(at.residual, at.J_measurement, edge.sqrt_information, 1.0,
                                          log_determinant);
  });
  return result;
}

}  // namespace imslam::pgo
