#include "pgo/pose_velocity_graph.hpp"

#include <gtest/gtest.h>

#include <limits>

#include "slam/base/error.hpp"
#include "tests/pgo/synthetic.hpp"

namespace imslam::pgo {
namespace {

using testing::chain_graph;
using testing::exact_imu_motion;
using testing::exact_visual_motion;
using testing::largest_position_error;
using testing::wavy_states;

double largest_error(const std::vector<State>& actual, const std::vector<State>& expected) {
  double error = 0.0;
  for (std::size_t i = 0; i < actual.size(); ++i) {
    error = std::max(error, actual[i].nav.minus(expected[i].nav).cwiseAbs().maxCoeff());
  }
  return error;
}

TEST(PoseVelocityGraph, RecoversExactVisualMotionWithoutImu) {
  const auto truth = wavy_states(200);
  PoseVelocityGraph graph = chain_graph(truth, {}, false, 0.05);
  const SolveReport report = graph.solve();
  EXPECT_TRUE(report.converged) << report.reason;
  EXPECT_LT(report.cost, 1e-12);
  EXPECT_LT(largest_position_error(graph.states(), truth), 1e-6);
}

TEST(PoseVelocityGraph, RecoversExactVisualInertialMotion) {
  const auto truth = wavy_states(200);
  PoseVelocityGraph graph = chain_graph(truth, {}, true, 0.05);
  const SolveReport report = graph.solve();
  EXPECT_TRUE(report.converged) << report.reason;
  EXPECT_LT(largest_error(graph.states(), truth), 1e-6);
}

TEST(PoseVelocityGraph, FindsTheBiasThatTheMeasurementsWereNotCorrectedFor) {
  ImuBias bias;
  bias.gyro << 0.01, -0.02, 0.03;
  bias.accel << 0.1, 0.05, -0.08;
  const auto truth = wavy_states(200, 0.05, bias);
  PoseVelocityGraph graph = chain_graph(truth, {}, true, 0.0);
  for (int i = 0; i < 200; ++i) {
    State state = graph.states()[static_cast<std::size_t>(i)];
    state.bias = {};
    graph.set_state(i, state);
  }
  EXPECT_TRUE(graph.solve().converged);
  for (const State& state : graph.states()) {
    EXPECT_LT((state.bias.gyro - bias.gyro).norm(), 1e-6);
    EXPECT_LT((state.bias.accel - bias.accel).norm(), 1e-6);
  }
}

TEST(PoseVelocityGraph, RobustKernelKeepsAWrongVisualEdgeFromBendingThePath) {
  const auto truth = wavy_states(60);
  PoseVelocityGraph graph = chain_graph(truth, {}, true, 0.0);
  RelativeMotion wrong = exact_visual_motion(truth[30], truth[31]);
  wrong.T_body0_body1 = wrong.T_body0_body1 * lie::SE3d::exp(0.5 * testing::Vector6::Ones());
  graph.data().visual_edges[30].motion = wrong;
  EXPECT_TRUE(graph.solve().converged);
  EXPECT_LT(largest_position_error(graph.states(), truth), 0.005);
}

TEST(PoseVelocityGraph, SaysWhyAnUnanchoredOrDisconnectedGraphCannotBeSolved) {
  const auto truth = wavy_states(3);
  PoseVelocityGraph graph;
  EXPECT_EQ(graph.solve().reason, "the graph has no states");
  for (const State& state : truth) graph.add_state(state);
  graph.add_visual_edge(0, 1, exact_visual_motion(truth[0], truth[1]));
  EXPECT_NE(graph.solve().reason.find("state 0 is not connected"), std::string::npos);
  graph.anchor_pose(0, truth[0].nav.T_world_body);
  const SolveReport report = graph.solve();
  EXPECT_FALSE(report.converged);
  EXPECT_NE(report.reason.find("state 2 is not connected"), std::string::npos);
}

TEST(PoseVelocityGraph, RefusesMeasurementsThatAreNotFiniteOrHaveNoCovariance) {
  const auto truth = wavy_states(2);
  PoseVelocityGraph graph;
  for (const State& state : truth) graph.add_state(state);
  RelativeMotion visual = exact_visual_motion(truth[0], truth[1]);
  visual.covariance(2, 2) = 0.0;
  EXPECT_FALSE(graph.add_visual_edge(0, 1, visual));
  visual = exact_visual_motion(truth[0], truth[1]);
  visual.J_disparity_offset(0) = std::numeric_limits<double>::quiet_NaN();
  EXPECT_FALSE(graph.add_visual_edge(0, 1, visual));
  ImuMotion inertial = exact_imu_motion(truth[0], truth[1]);
  inertial.covariance(0, 0) = std::numeric_limits<double>::infinity();
  EXPECT_FALSE(graph.add_imu_edge(0, 1, inertial));
  EXPECT_TRUE(graph.visual_edges().empty() && graph.inertial_edges().empty());
}

TEST(PoseVelocityGraph, GivesTheSameBitsForAnyThreadCount) {
  const auto truth = wavy_states(150);
  std::vector<Eigen::VectorXd> results;
  for (int threads : {1, 2, 4}) {
    PoseVelocityGraph graph = chain_graph(truth, {}, true, 0.05, 7);
    for (auto& edge : graph.data().visual_edges)
      edge.motion.T_body0_body1 =
          edge.motion.T_body0_body1 * lie::SE3d::exp(1e-3 * testing::Vector6::Ones());
    SolverOptions options;
    options.threads = threads;
    graph.solve(options);
    Eigen::VectorXd all(9 * 150);
    for (int i = 0; i < 150; ++i) {
      all.segment<9>(9 * i) = graph.states()[static_cast<std::size_t>(i)].nav.minus({});
    }
    results.push_back(all);
  }
  EXPECT_TRUE(results[0] == results[1] && results[0] == results[2]);
}

TEST(PoseVelocityGraph, RejectsOptionsOutOfBounds) {
  GraphOptions options;
  options.kernel_width = 0.0;
  EXPECT_THROW(PoseVelocityGraph{options}, InputError);
}

}  // namespace
}  // namespace imslam::pgo
