#include "pgo/residual_posterior.hpp"

#include <gtest/gtest.h>

#include "pgo/whitening.hpp"
#include "tests/slam/system/contradictory_graph.hpp"
#include "tests/support/numeric_jacobian.hpp"

namespace imslam::pgo {
namespace {

using imslam::system::testing::contradictory_graph;
using imslam::testing::random_matrix;

/// Slope of 1/2 log det J^T J alone.
MeasurementGradient slope_of_term(const PoseVelocityGraph& graph) {
  MeasurementGradient gradient = measurement_gradient(graph);
  const MeasurementGradient before = gradient;
  residual_posterior(graph)->add_to(graph.data(), gradient);
  for (std::size_t e = 0; e < before.visual.size(); ++e) {
    gradient.visual[e].covariance -= before.visual[e].covariance;
  }
  for (std::size_t e = 0; e < before.inertial.size(); ++e) {
    gradient.inertial[e].covariance -= before.inertial[e].covariance;
  }
  for (std::size_t k = 0; k < before.bias_priors.size(); ++k) {
    gradient.bias_priors[k].log_sigma -= before.bias_priors[k].log_sigma;
  }
  return gradient;
}

/// By central differences along one change of the graph, the states held.
template <typename Change>
double differences(const PoseVelocityGraph& graph, const Change& change) {
  const auto term = [&](const Eigen::VectorXd& step) -> Eigen::VectorXd {
    PoseVelocityGraph changed = graph;
    change(step(0), changed.data());
    return Eigen::VectorXd::Constant(1, residual_posterior(changed)->half_log_determinant);
  };
  return imslam::testing::numeric_jacobian(term, Eigen::VectorXd::Zero(1), 1e-4)(0);
}

TEST(ResidualPosterior, SlopesByCovariancesMatchCentralDifferences) {
  const PoseVelocityGraph graph = contradictory_graph(6, true);
  const MeasurementGradient slope = slope_of_term(graph);
  Random random(8);
  for (const std::size_t e : {1U, 3U}) {
    const Eigen::Matrix<double, 6, 6> A = random_matrix<6, 6>(random);
    const Eigen::Matrix<double, 6, 6> direction = 1e-4 * (A + A.transpose());
    const double numeric = differences(graph, [&](double step, GraphData& data) {
      VisualEdge& edge = data.visual_edges[e];
      edge.sqrt_information = *sqrt_information(edge.motion.covariance + step * direction);
    });
    EXPECT_NEAR(slope.visual[e].covariance.cwiseProduct(direction).sum(), numeric,
                1e-6 * std::abs(numeric));
  }
  const Eigen::Matrix<double, 9, 9> A = random_matrix<9, 9>(random);
  const Eigen::Matrix<double, 9, 9> direction = 1e-4 * (A + A.transpose());
  const double numeric = differences(graph, [&](double step, GraphData& data) {
    InertialEdge& edge = data.inertial_edges[2];
    edge.sqrt_information = *sqrt_information(edge.motion.covariance + step * direction);
  });
  EXPECT_NEAR(slope.inertial[2].covariance.cwiseProduct(direction).sum(), numeric,
              1e-6 * std::abs(numeric));
}

TEST(ResidualPosterior, SlopesByPriorSigmasMatchCentralDifferences) {
  const PoseVelocityGraph graph = contradictory_graph(6, true);
  const MeasurementGradient slope = slope_of_term(graph);
  for (const Eigen::Index axis : {0, 4}) {
    const double numeric = differences(graph, [axis](double step, GraphData& data) {
      ImuBias& sigma = data.bias_priors[1].sigma;
      (axis < 3 ? sigma.gyro(axis) : sigma.accel(axis - 3)) *= std::exp(step);
    });
    EXPECT_NEAR(slope.bias_priors[1].log_sigma(axis), numeric, 1e-6 * std::abs(numeric));
  }
}

TEST(ResidualPosterior, StatesTakeAsManyResidualsAsThereAreUnknowns) {
  // trace(J P J^T) over all residuals = number of unknowns; priors and walks take the rest.
  const PoseVelocityGraph graph = contradictory_graph(6, false);
  const auto posterior = residual_posterior(graph);
  double taken = 0.0;
  for (const auto& edge : posterior->visual) taken += edge.trace();
  const double offset_prior = std::pow(*graph.uncertainty()->globals.disparity_offset / 0.5, 2);
  EXPECT_NEAR(taken + 6.0 + offset_prior, 6.0 * 6.0 + 1.0, 1e-6);  // the anchor takes 6
}

}  // namespace
}  // namespace imslam::pgo
