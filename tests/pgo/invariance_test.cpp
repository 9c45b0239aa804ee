#include <gtest/gtest.h>

#include "pgo/pose_velocity_graph.hpp"
#include "tests/pgo/synthetic.hpp"

namespace imslam::pgo {
namespace {

using Eigen::Vector3d;
using testing::random_matrix;
using testing::wavy_states;

/// Noisy edges, made once, so that only the world around them changes.
struct Edges {
  std::vector<State> truth = wavy_states(80);
  std::vector<RelativeMotion> visual;
  std::vector<ImuMotion> inertial;
};

Edges noisy_edges() {
  Edges edges;
  Random random(3);
  for (std::size_t i = 0; i + 1 < edges.truth.size(); ++i) {
    RelativeMotion visual = testing::exact_visual_motion(edges.truth[i], edges.truth[i + 1]);
    visual.T_body0_body1 =
        visual.T_body0_body1 * lie::SE3d::exp(1e-3 * random_matrix<6, 1>(random));
    edges.visual.push_back(visual);
    ImuMotion inertial = testing::exact_imu_motion(edges.truth[i], edges.truth[i + 1]);
    inertial.dv += 1e-3 * random.normal3();
    inertial.dR = inertial.dR * lie::SO3d::exp(1e-4 * random.normal3());
    edges.inertial.push_back(inertial);
  }
  return edges;
}

/// Solves the same edges in the world moved by T_new_old, stamps moved by `shift_ns`.
std::vector<State> solve(const Edges& edges,
                         const lie::SE3d& T_new_old,
                         std::int64_t shift_ns,
                         bool with_imu) {
  PoseVelocityGraph graph;
  for (State state : edges.truth) {
    state.time_ns += shift_ns;
    state.nav.T_world_body = T_new_old * state.nav.T_world_body;
    state.nav.v_world = T_new_old.rotation() * state.nav.v_world;
    graph.add_state(state);
  }
  for (std::size_t i = 0; i < edges.visual.size(); ++i) {
    const int from = static_cast<int>(i);
    graph.add_visual_edge(from, from + 1, edges.visual[i]);
    if (with_imu) graph.add_imu_edge(from, from + 1, edges.inertial[i]);
  }
  const lie::SE3d first = graph.states()[0].nav.T_world_body;
  if (with_imu) {
    graph.anchor_position_and_heading(0, first);
    graph.add_bias_prior(0, {}, 0.01, 0.1);
  } else {
    graph.anchor_pose(0, first);
  }
  SolverOptions options;
  options.function_tolerance = 1e-15;
  EXPECT_TRUE(graph.solve(options).converged);
  graph.solve(options);  // again, without damping left over: to where rounding ends it
  return graph.states();
}

void expect_moved(const std::vector<State>& actual,
                  const std::vector<State>& expected,
                  const lie::SE3d& T_new_old,
                  double tolerance) {
  for (std::size_t i = 0; i < actual.size(); ++i) {
    lie::NavState moved;
    moved.T_world_body = T_new_old * expected[i].nav.T_world_body;
    moved.v_world = T_new_old.rotation() * expected[i].nav.v_world;
    EXPECT_LT(actual[i].nav.minus(moved).cwiseAbs().maxCoeff(), tolerance) << i;
    EXPECT_LT((actual[i].bias.gyro - expected[i].bias.gyro).norm(), tolerance) << i;
    EXPECT_LT((actual[i].bias.accel - expected[i].bias.accel).norm(), tolerance) << i;
  }
}

TEST(Invariance, VisualGraphMovesRigidlyWithTheWorld) {
  const Edges edges = noisy_edges();
  Random random(8);
  const lie::SE3d T_new_old = testing::random_pose(random, 20.0, 1.0);
  expect_moved(solve(edges, T_new_old, 0, false), solve(edges, {}, 0, false), T_new_old, 1e-9);
}

TEST(Invariance, InertialGraphMovesWithPositionAndHeadingOfTheWorld) {
  const Edges edges = noisy_edges();
  const lie::SE3d T_new_old(lie::SO3d::exp(Vector3d(0.0, 0.0, 2.2)), Vector3d(10.0, -20.0, 5.0));
  expect_moved(solve(edges, T_new_old, 0, true), solve(edges, {}, 0, true), T_new_old, 1e-8);
}

TEST(Invariance, InertialGraphNoticesATiltOfTheWorld) {
  const Edges edges = noisy_edges();
  const lie::SE3d tilt(lie::SO3d::exp(Vector3d(0.2, 0.0, 0.0)), Vector3d::Zero());
  const auto level = solve(edges, {}, 0, true);
  const auto tilted = solve(edges, tilt, 0, true);
  EXPECT_GT(tilted.back().nav.minus(level.back().nav).norm(), 1e-9);
  const lie::SO3d gap = tilted.back().nav.T_world_body.rotation() *
                        level.back().nav.T_world_body.rotation().inverse();
  EXPECT_LT((gap * Vector3d::UnitZ() - Vector3d::UnitZ()).norm(), 1e-6);  // gravity wins
}

TEST(Invariance, AShiftOfAllStampsChangesNothing) {
  const Edges edges = noisy_edges();
  expect_moved(solve(edges, {}, 1'403'636'579'763'555'584, true), solve(edges, {}, 0, true), {},
               1e-12);
}

}  // namespace
}  // namespace imslam::pgo
