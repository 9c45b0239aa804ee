#include "slam/system/slam_upper_cost.hpp"

#include "pgo/measurement_gradient.hpp"
#include "pgo/residual_posterior.hpp"
#include "slam/base/error.hpp"

namespace imslam::system {
namespace {

using learner::UpperValue;
using learner::Vector;
using Vector6 = lie::SE3d::Tangent;

void leave_out(const pgo::EdgeSelection& only, pgo::MeasurementGradient& gradient) {
  for (std::size_t e = 0; e < only.visual.size(); ++e) {
    if (only.visual[e] == 0) gradient.visual[e] = {Vector6::Zero(), lie::SE3d::Matrix6::Zero()};
  }
  for (std::size_t e = 0; e < only.inertial.size(); ++e) {
    if (only.inertial[e] != 0) continue;
    gradient.inertial[e].motion.setZero();
    gradient.inertial[e].covariance.setZero();
  }
  for (pgo::BiasPriorGradient& prior : gradient.bias_priors) {
    prior = {Vector6::Zero(), Vector6::Zero()};
  }
}

double sum_of(const std::vector<double>& parts, const std::vector<char>& counts) {
  double sum = 0.0;
  for (std::size_t i = 0; i < parts.size(); ++i) sum += counts[i] != 0 ? parts[i] : 0.0;
  return sum;
}

UpperValue likelihood(const std::optional<pgo::EdgeSelection>& only,
                      const pgo::PoseVelocityGraph& solved,
                      const pgo::GraphPoint& point,
                      const MeasurementCoordinates& coordinates,
                      const Vector& z) {
  const pgo::NegativeLogLikelihood parts = pgo::negative_log_likelihood(solved);
  pgo::MeasurementGradient gradient = pgo::measurement_gradient(solved, true);
  if (!only) return {parts.total(), coordinates.pull_back(z, gradient), point.gradient()};
  const Vector by_tau = point.gradient(*only);  // checks the selection
  leave_out(*only, gradient);
  return {sum_of(parts.visual, only->visual) + sum_of(parts.inertial, only->inertial),
          coordinates.pull_back(z, gradient), by_tau};
}

UpperValue marginal(const pgo::PoseVelocityGraph& solved,
                    const pgo::GraphPoint& point,
                    const MeasurementCoordinates& coordinates,
                    const Vector& z) {
  const auto posterior = pgo::residual_posterior(solved);
  expects(posterior.has_value(), "slam upper cost: asked at states that are not determined");
  pgo::MeasurementGradient gradient = pgo::measurement_gradient(solved, true);
  posterior->add_to(solved.data(), gradient);
  return {pgo::negative_log_likelihood(solved).total() + posterior->half_log_determinant,
          coordinates.pull_back(z, gradient), Vector::Zero(point.size())};
}

/// As published: the steps of vision alone, one weight, no kernel, no calibration.
UpperValue published(const SlamUpperOptions& options,
                     const pgo::PoseVelocityGraph& solved,
                     const pgo::GraphPoint& point,
                     const MeasurementCoordinates& coordinates,
                     const Vector& z) {
  const auto& edges = solved.visual_edges();
  const double information = options.published_weight * options.published_weight;
  pgo::MeasurementGradient gradient;
  gradient.visual.resize(edges.size());
  gradient.inertial.resize(solved.inertial_edges().size());
  gradient.bias_priors.resize(solved.data().bias_priors.size());
  leave_out({std::vector<char>(edges.size()), std::vector<char>(gradient.inertial.size())},
            gradient);
  UpperValue upper{0.0, {}, Vector::Zero(point.size())};
  const auto pose = [&solved](int state) -> const lie::SE3d& {
    return solved.states()[static_cast<std::size_t>(state)].nav.T_world_body;
  };
  for (std::size_t e = 0; e < edges.size(); ++e) {
    const pgo::VisualEdge& edge = edges[e];
    if (edge.to != edge.from + 1 || (options.only && options.only->visual[e] == 0)) continue;
    const lie::SE3d T_body0_body1 = pose(edge.from).inverse() * pose(edge.to);
    const lie::SE3d error = edge.motion.T_body0_body1.inverse() * T_body0_body1;
    const Vector6 r = error.log();
    upper.cost += 0.5 * information * r.squaredNorm();
    // By error Exp(tau); T0 Exp(tau) and P Exp(tau) act on it as Exp(-Ad tau) on its right.
    const Vector6 slope = information * lie::SE3d::right_jacobian_inverse(r).transpose() * r;
    gradient.visual[e].motion = -error.inverse().adjoint().transpose() * slope;
    upper.by_phi.segment<6>(point.offset({pgo::BlockId::Kind::kPose, edge.to})) += slope;
    upper.by_phi.segment<6>(point.offset({pgo::BlockId::Kind::kPose, edge.from})) -=
        T_body0_body1.inverse().adjoint().transpose() * slope;
  }
  upper.by_z = coordinates.pull_back(z, gradient);
  return upper;
}

}  // namespace

UpperValue slam_upper_cost(const SlamUpperOptions& options,
                           const pgo::PoseVelocityGraph& solved,
                           const pgo::GraphPoint& point,
                           const MeasurementCoordinates& coordinates,
                           const Vector& z) {
  UpperValue upper = [&] {
    switch (options.kind) {
      case UpperKind::kPublished:
        return published(options, solved, point, coordinates, z);
      case UpperKind::kMarginal:
        expects(!options.only, "slam upper cost: kMarginal is of all edges");
        return marginal(solved, point, coordinates, z);
      case UpperKind::kGraph:
        break;
    }
    return likelihood(options.only, solved, point, coordinates, z);
  }();
  if (!options.extra) return upper;
  const UpperValue extra = options.extra(solved.data(), z);
  upper.cost += extra.cost;
  if (extra.by_z.size() > 0) upper.by_z += extra.by_z;
  if (extra.by_phi.size() > 0) upper.by_phi += extra.by_phi;
  return upper;
}

}  // namespace imslam::system
