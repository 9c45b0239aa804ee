#include "pgo/edge_likelihood.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "pgo/edge_linearization.hpp"
#include "tests/pgo/synthetic.hpp"

namespace imslam::pgo {
namespace {

using testing::random_covariance;
using testing::random_matrix;
using testing::Vector6;
using testing::wavy_states;

constexpr std::size_t kEdge = 5;  // of vision: from state 3 to 4

SolverOptions to_the_last_digit() {
  SolverOptions options;
  options.function_tolerance = 0.0;
  options.parameter_tolerance = 1e-15;
  options.gradient_tolerance = 1e-13;
  return options;
}

/// Vision with skip edges and noise so small that the graph is all but linear. `without`: this edge
/// is left out.
PoseVelocityGraph graph_of_vision(std::size_t without) {
  Random random(5);
  const auto truth = wavy_states(8, 0.5);
  GraphOptions options;
  options.kernel = "none";
  PoseVelocityGraph graph(options);
  for (const State& state : truth) graph.add_state(state);
  std::size_t number = 0;
  const auto add = [&](std::size_t i, std::size_t j) {
    RelativeMotion motion = testing::exact_visual_motion(truth[i], truth[j]);
    motion.covariance = 1e-8 * random_covariance<6>(random, 1.0);
    const Vector6 noise = 1e-4 * random_matrix<6, 1>(random);
    motion.T_body0_body1 = motion.T_body0_body1 * lie::SE3d::exp(noise);
    if (number++ != without) {
      EXPECT_TRUE(graph.add_visual_edge(static_cast<int>(i), static_cast<int>(j), motion));
    }
  };
  for (std::size_t j = 1; j < 8; ++j) {
    add(j - 1, j);
    if (j >= 2) add(j - 2, j);
  }
  graph.anchor_pose(0, truth[0].nav.T_world_body);
  EXPECT_TRUE(graph.solve(to_the_last_digit()).converged);
  return graph;
}

TEST(EdgeLikelihood, WhatTheOthersForetellIsWhatTheySayWithoutTheEdge) {
  const PoseVelocityGraph all = graph_of_vision(1000);
  const PoseVelocityGraph others = graph_of_vision(kEdge);
  const auto posterior = residual_posterior(all);
  ASSERT_TRUE(posterior);
  const Foretold<6> foretold = foretold_visual(all, *posterior, kEdge);
  const VisualEdge& edge = all.visual_edges()[kEdge];
  const auto unwhitened = [&](const PoseVelocityGraph& graph) -> Vector6 {
    return edge.sqrt_information.triangularView<Eigen::Lower>().solve(
        linearize(edge, graph.data()).residual);
  };
  const Vector6 with_it = unwhitened(all);
  const Vector6 without = unwhitened(others);
  EXPECT_GT((without - with_it).norm(), 0.1 * without.norm());  // the edge does pull
  EXPECT_LT((with_it + foretold.shift - without).norm(), 2e-3 * without.norm());
}

TEST(EdgeLikelihood, ItsSlopesMatchCentralDifferences) {
  const PoseVelocityGraph graph = graph_of_vision(1000);
  const auto posterior = residual_posterior(graph);
  ASSERT_TRUE(posterior);
  const Foretold<6> others = foretold_visual(graph, *posterior, kEdge);
  const RelativeMotion motion = graph.visual_edges()[kEdge].motion;
  const auto nll = [&](const RelativeMotion& m) {
    return visual_likelihood(graph, kEdge, m, others).nll;
  };
  const auto at = visual_likelihood(graph, kEdge, motion, others);
  for (int k = 0; k < 6; ++k) {
    const double h = 1e-8;
    RelativeMotion above = motion;
    RelativeMotion below = motion;
    above.T_body0_body1 = motion.T_body0_body1 * lie::SE3d::exp(h * Vector6::Unit(k));
    below.T_body0_body1 = motion.T_body0_body1 * lie::SE3d::exp(-h * Vector6::Unit(k));
    const double slope = (nll(above) - nll(below)) / (2.0 * h);
    EXPECT_NEAR(at.gradient.motion[k], slope, 1e-5 * at.gradient.motion.norm());

    const double step = 1e-5 * motion.covariance(k, k);
    above = below = motion;
    above.covariance(k, k) += step;
    below.covariance(k, k) -= step;
    const double by_variance = (nll(above) - nll(below)) / (2.0 * step);
    EXPECT_NEAR(at.gradient.covariance(k, k), by_variance, 1e-5 * at.gradient.covariance.norm());
  }
}

TEST(EdgeLikelihood, WithoutOthersItIsTheGraphsOwnCost) {
  const PoseVelocityGraph graph = graph_of_vision(1000);
  double sum = 0.0;
  for (std::size_t e = 0; e < graph.visual_edges().size(); ++e) {
    const RelativeMotion& motion = graph.visual_edges()[e].motion;
    const auto& W = graph.visual_edges()[e].sqrt_information;
    sum += visual_likelihood(graph, e, motion).nll + W.diagonal().array().log().sum();
  }
  EXPECT_NEAR(sum, graph.cost(), 1e-9 * graph.cost());
}

}  // namespace
}  // namespace imslam::pgo
