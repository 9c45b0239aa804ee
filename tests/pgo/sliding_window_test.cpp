#include "pgo/sliding_window.hpp"

#include <gtest/gtest.h>

#include <algorithm>

#include "pgo/marginalization.hpp"
#include "pgo/prediction.hpp"
#include "tests/pgo/synthetic.hpp"

namespace imslam::pgo {
namespace {

using testing::wavy_states;

constexpr int kFrames = 60;

/// Measurements with noise so small that the graph is linear to working precision.
struct Measurements {
  std::vector<State> truth = wavy_states(kFrames, 0.1);
  std::vector<RelativeMotion> visual;  ///< i -> i + 1
  std::vector<RelativeMotion> skip;    ///< i -> i + 2
  std::vector<ImuMotion> inertial;
};

Measurements measure(double noise) {
  Measurements m;
  Random random(9);
  const auto disturb = [&](RelativeMotion motion) {
    const testing::Vector6 sigma = motion.covariance.diagonal().cwiseSqrt();
    motion.T_body0_body1 =
        motion.T_body0_body1 *
        lie::SE3d::exp(noise * sigma.cwiseProduct(testing::random_matrix<6, 1>(random)));
    motion.J_disparity_offset << 0.0, 0.0, 0.01, 0.0, 0.0, 0.0;
    return motion;
  };
  for (std::size_t i = 0; i + 1 < m.truth.size(); ++i) {
    m.visual.push_back(disturb(testing::exact_visual_motion(m.truth[i], m.truth[i + 1])));
    if (i + 2 < m.truth.size()) {
      m.skip.push_back(disturb(testing::exact_visual_motion(m.truth[i], m.truth[i + 2])));
    }
    ImuMotion motion = testing::exact_imu_motion(m.truth[i], m.truth[i + 1]);
    motion.dv += noise * 1e-3 * random.normal3();
    motion.dp += noise * 3e-5 * random.normal3();
    motion.dR = motion.dR * lie::SO3d::exp(noise * 1e-4 * random.normal3());
    m.inertial.push_back(motion);
  }
  return m;
}

GraphOptions graph_options() {
  GraphOptions options;
  options.kernel = "none";
  options.estimate_disparity_offset = true;
  return options;
}

PoseVelocityGraph first_state_only(const Measurements& m) {
  PoseVelocityGraph graph(graph_options());
  graph.add_state(m.truth[0]);
  graph.anchor_position_and_heading(0, m.truth[0].nav.T_world_body);
  graph.add_bias_prior(0, {}, 0.01, 0.1);
  graph.add_velocity_prior(0, m.truth[0].nav.v_world, 0.1);
  graph.add_disparity_offset_prior(0.0, 0.3);
  return graph;
}

template <typename Graph>
void add_edges(Graph& graph, const Measurements& m, int to) {
  const auto i = static_cast<std::size_t>(to);
  ASSERT_TRUE(graph.add_visual_edge(to - 1, to, m.visual[i - 1]));
  ASSERT_TRUE(graph.add_imu_edge(to - 1, to, m.inertial[i - 1]));
  if (to < 2) return;
  ASSERT_TRUE(graph.add_visual_edge(to - 2, to, m.skip[i - 2]));
}

TEST(SlidingWindow, EqualsTheBatchSolutionOnALinearChain) {
  const Measurements m = measure(1e-3);
  SolverOptions exact;
  exact.function_tolerance = 0.0;
  WindowOptions options;
  options.states = 6;
  options.max_iterations = 20;
  options.function_tolerance = 0.0;
  SlidingWindow window(first_state_only(m), options);
  PoseVelocityGraph batch = first_state_only(m);
  for (int to = 1; to < kFrames; ++to) {
    window.add_state(m.truth[static_cast<std::size_t>(to)]);
    batch.add_state(m.truth[static_cast<std::size_t>(to)]);
    add_edges(window, m, to);
    add_edges(batch, m, to);
    window.update();
  }
  batch.solve(exact);
  EXPECT_EQ(window.first(), kFrames - 6);
  // Deviations of the estimate from the truth are 1e-5; the two must share them to 1 in 1e4.
  const auto& expected = batch.states().back();
  EXPECT_GT(expected.nav.minus(m.truth.back().nav).norm(), 1e-7);
  for (int number = window.first(); number < window.end(); ++number) {
    const auto& state = batch.states()[static_cast<std::size_t>(number)];
    EXPECT_LT(window.state(number).nav.minus(state.nav).cwiseAbs().maxCoeff(), 1e-9) << number;
    EXPECT_LT((window.state(number).bias.accel - state.bias.accel).norm(), 1e-8);
    EXPECT_LT((window.state(number).bias.gyro - state.bias.gyro).norm(), 1e-9);
  }
  EXPECT_NEAR(window.globals().disparity_offset, batch.globals().disparity_offset, 1e-7);

  const auto window_covariance = window.graph().covariance(5);
  const auto batch_covariance = batch.covariance(kFrames - 1);
  ASSERT_TRUE(window_covariance && batch_covariance);
  const Eigen::VectorXd ratio =
      window_covariance->diagonal().cwiseQuotient(batch_covariance->diagonal());
  EXPECT_LT((ratio.array() - 1.0).abs().maxCoeff(), 1e-3);
}

TEST(SlidingWindow, StaysCloseToTheBatchWithRealNoise) {
  const Measurements m = measure(1.0);
  WindowOptions options;
  SlidingWindow window(first_state_only(m), options);
  PoseVelocityGraph batch = first_state_only(m);
  for (int to = 1; to < kFrames; ++to) {
    const State guess =
        predict(window.newest(), m.inertial[static_cast<std::size_t>(to - 1)], {0.0, 0.0, -9.81});
    window.add_state(guess);
    batch.add_state(guess);
    add_edges(window, m, to);
    add_edges(batch, m, to);
    const SolveReport report = window.update();
    EXPECT_LE(report.iterations, options.max_iterations);
  }
  batch.solve();
  const lie::NavState::Tangent gap = window.newest().nav.minus(batch.states().back().nav);
  const auto covariance = batch.covariance(kFrames - 1);
  ASSERT_TRUE(covariance);
  const Eigen::VectorXd sigmas = covariance->diagonal().head<9>().cwiseSqrt();
  EXPECT_LT(gap.cwiseAbs().cwiseQuotient(sigmas).maxCoeff(), 0.2);
}

TEST(SlidingWindow, WorksWithoutImu) {
  const Measurements m = measure(1e-3);
  GraphOptions options;
  options.kernel = "none";
  PoseVelocityGraph batch(options);
  batch.add_state(m.truth[0]);
  batch.anchor_pose(0, m.truth[0].nav.T_world_body);
  WindowOptions window_options;
  window_options.states = 5;
  SlidingWindow window(batch, window_options);
  for (int to = 1; to < kFrames; ++to) {
    const auto i = static_cast<std::size_t>(to);
    window.add_state(predict(window.newest(), m.visual[i - 1]));
    batch.add_state(m.truth[i]);
    for (int from = std::max(0, to - 2); from < to; ++from) {
      const auto& motion = from == to - 1 ? m.visual[i - 1] : m.skip[i - 2];
      ASSERT_TRUE(window.add_visual_edge(from, to, motion));
      ASSERT_TRUE(batch.add_visual_edge(from, to, motion));
    }
    window.update();
  }
  batch.solve();
  EXPECT_LT(window.newest().nav.minus(batch.states().back().nav).head<6>().norm(), 1e-8);
}

TEST(SlidingWindow, RefusesEdgesToStatesThatHaveLeft) {
  const Measurements m = measure(1.0);
  WindowOptions options;
  options.states = 3;
  SlidingWindow window(first_state_only(m), options);
  for (int to = 1; to < 6; ++to) {
    window.add_state(m.truth[static_cast<std::size_t>(to)]);
    add_edges(window, m, to);
    window.update();
  }
  EXPECT_EQ(window.first(), 3);
  EXPECT_FALSE(window.add_visual_edge(2, 5, m.visual[2]));
  EXPECT_FALSE(window.add_zero_velocity(0));
  EXPECT_TRUE(window.add_zero_velocity(5));
}

TEST(SlidingWindow, KeepsTheStateWhereAMeasurementIsToBeginForThreeWindowsAtMost) {
  const Measurements m = measure(1.0);
  WindowOptions options;
  options.states = 4;
  SlidingWindow window(first_state_only(m), options);
  const auto add = [&](int to) {
    window.add_state(m.truth[static_cast<std::size_t>(to)]);
    add_edges(window, m, to);
  };
  for (int to = 1; to <= 13; ++to) {
    add(to);
    window.update(2);
    EXPECT_EQ(window.first(), std::clamp(to - 3, 0, 2)) << to;
  }
  EXPECT_TRUE(window.add_visual_edge(2, 13, testing::exact_visual_motion(m.truth[2], m.truth[13])));
  add(14);
  window.update(2);
  EXPECT_EQ(window.first(), 3);  // three windows of four are full
  add(15);
  window.update();
  EXPECT_EQ(window.first(), 12);
}

}  // namespace
}  // namespace imslam::pgo
