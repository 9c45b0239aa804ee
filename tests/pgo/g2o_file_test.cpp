#include "pgo/g2o_file.hpp"

#include <ceres/ceres.h>
#include <gtest/gtest.h>

#include <fstream>

#include "pgo/pose_block.hpp"
#include "pgo/pose_velocity_graph.hpp"
#include "slam/base/error.hpp"
#include "tests/pgo/synthetic.hpp"
#include "tests/support/numeric_jacobian.hpp"
#include "tests/support/temp_dir.hpp"
#include "tests/support/test_data.hpp"

namespace imslam::pgo {
namespace {

using testing::expect_near;

/// The residual of the published benchmark figures, as in the pose graph example of Ceres:
/// [t_0_1 - t_measured, 2 vec(q_measured q_0_1^-1)]. By automatic differentiation, so independent
/// of our factor.
struct QuaternionError {
  template <typename T>
  bool operator()(const T* pose0, const T* pose1, T* residual) const {
    const lie::SE3<T> T_0_1 = pose_from_block(pose0).inverse() * pose_from_block(pose1);
    const lie::SO3<T> turn = measured.rotation().cast<T>() * T_0_1.rotation().inverse();
    Eigen::Matrix<T, 6, 1> e;
    e << T_0_1.translation() - measured.translation().cast<T>(), T(2) * turn.quaternion().vec();
    Eigen::Map<Eigen::Matrix<T, 6, 1>> r(residual);
    r = W.cast<T>() * e;
    return true;
  }
  lie::SE3d measured;
  Eigen::Matrix<double, 6, 6> W;
};

/// Minimal cost in the published definition, starting from `graph`'s states.
double published_cost(const GraphData& graph, int iterations) {
  std::vector<std::array<double, 7>> poses(graph.states.size());
  const PoseManifold manifold;
  ceres::Problem::Options ownership;
  ownership.manifold_ownership = ceres::DO_NOT_TAKE_OWNERSHIP;
  ceres::Problem problem(ownership);
  for (std::size_t i = 0; i < poses.size(); ++i) {
    pose_to_block(graph.states[i].nav.T_world_body, poses[i].data());
    problem.AddParameterBlock(poses[i].data(), 7, const_cast<PoseManifold*>(&manifold));
  }
  for (const VisualEdge& edge : graph.visual_edges) {
    problem.AddResidualBlock(
        new ceres::AutoDiffCostFunction<QuaternionError, 6, 7, 7>(
            new QuaternionError{edge.motion.T_body0_body1, edge.sqrt_information}),
        nullptr, poses[static_cast<std::size_t>(edge.from)].data(),
        poses[static_cast<std::size_t>(edge.to)].data());
  }
  problem.SetParameterBlockConstant(poses[0].data());
  ceres::Solver::Options options;
  options.linear_solver_type = ceres::SPARSE_NORMAL_CHOLESKY;
  options.max_num_iterations = iterations;
  options.initial_trust_region_radius = 1e10;
  options.logging_type = ceres::SILENT;
  ceres::Solver::Summary summary;
  ceres::Solve(options, &problem, &summary);
  return summary.final_cost;
}

PoseVelocityGraph solved_benchmark(const std::filesystem::path& file) {
  GraphOptions options;
  options.kernel = "none";
  PoseVelocityGraph graph(options);
  graph.data() = read_g2o(file, G2oTangent::kRotationVector);
  graph.anchor_pose(0, graph.states()[0].nav.T_world_body);
  SolverOptions solver;
  solver.function_tolerance = 1e-7;
  const SolveReport report = graph.solve(solver);
  EXPECT_TRUE(report.converged) << report.reason;
  EXPECT_LE(report.iterations, 12);
  return graph;
}

TEST(G2o, SphereReachesThePublishedMinimum) {
  const auto file = testing::test_data() / "pose_graphs/sphere2500.g2o";
  IMSLAM_NEEDS(file);
  const PoseVelocityGraph graph = solved_benchmark(file);
  // Our residual is Log(error), the published one differs in second order: the minima lie close
  // together.
  EXPECT_NEAR(graph.cost(), 677.0, 0.02 * 677.0);
  EXPECT_NEAR(published_cost(graph.data(), 4), 677.0, 0.1);
}

TEST(G2o, ParkingGarageReachesThePublishedMinimum) {
  const auto file = testing::test_data() / "pose_graphs/parking-garage.g2o";
  IMSLAM_NEEDS(file);
  const PoseVelocityGraph graph = solved_benchmark(file);
  EXPECT_NEAR(graph.cost(), 0.6342, 0.02 * 0.6342);
  EXPECT_NEAR(published_cost(graph.data(), 4), 0.6342, 1e-4);
}

TEST(G2o, ReadsBackWhatItWrites) {
  Random random(4);
  PoseVelocityGraph graph = testing::chain_graph(testing::wavy_states(5), {}, false, 0.1);
  for (VisualEdge& edge : graph.data().visual_edges) {
    RelativeMotion motion = edge.motion;
    motion.covariance = testing::random_covariance<6>(random, 0.01);
    const auto index = static_cast<std::size_t>(&edge - graph.data().visual_edges.data());
    ASSERT_TRUE(graph.set_visual_motion(index, motion));
  }
  const testing::TempDir folder;
  const auto file = folder.path() / "graph.g2o";
  write_g2o(graph.data(), file);
  const GraphData back = read_g2o(file);
  ASSERT_EQ(back.states.size(), 5U);
  ASSERT_EQ(back.visual_edges.size(), 4U);
  for (std::size_t i = 0; i < 5; ++i) {
    EXPECT_LT(back.states[i].nav.minus(graph.states()[i].nav).head<6>().norm(), 1e-12);
  }
  for (std::size_t i = 0; i < 4; ++i) {
    expect_near(1e4 * back.visual_edges[i].motion.covariance,
                1e4 * graph.visual_edges()[i].motion.covariance, 1e-9);
  }
}

TEST(G2o, WritesInformationOfTheQuaternionVector) {
  // 0.5 [rad] of error is 0.25 of vec(q): the information of vec(q) is four times as large.
  PoseVelocityGraph graph = testing::chain_graph(testing::wavy_states(2), {}, false, 0.0);
  RelativeMotion motion = graph.visual_edges()[0].motion;
  motion.covariance = Eigen::Matrix<double, 6, 6>::Identity();
  ASSERT_TRUE(graph.set_visual_motion(0, motion));
  const testing::TempDir folder;
  const auto file = folder.path() / "graph.g2o";
  write_g2o(graph.data(), file);
  const GraphData raw = read_g2o(file, G2oTangent::kRotationVector);
  Eigen::Matrix<double, 6, 1> expected;
  expected << 1, 1, 1, 0.25, 0.25, 0.25;
  expect_near(raw.visual_edges[0].motion.covariance.diagonal(), expected, 1e-12);
}

TEST(G2o, NamesTheLineOfAMalformedFile) {
  const testing::TempDir folder;
  const std::string vertex = "VERTEX_SE3:QUAT 0 0 0 0 0 0 0 1\n";
  const std::pair<std::string, std::string> cases[] = {
      {vertex + "VERTEX_SE3:QUAT 1 0 0 nan 0 0 0 1\n", ":2: expected a finite number as word 5"},
      {vertex + vertex, ":2: vertex id occurs twice"},
      {"VERTEX_SE3:QUAT 0 0 0 0 0 0 0\n", ":1: expected VERTEX_SE3:QUAT id"},
      {"VERTEX_SE3:QUAT 0 0 0 0 0 0 0 3\n", ":1: expected a unit quaternion"},
      {"\nVERTEX2 0 1 2 3\n", ":2: expected VERTEX_SE3:QUAT or EDGE_SE3:QUAT"},
      {vertex + "EDGE_SE3:QUAT 0 7 0 0 0 0 0 0 1 1 0 0 0 0 0 1 0 0 0 0 1 0 0 0 1 0 0 1 0\n",
       ":2: expected EDGE_SE3:QUAT"},
      {vertex + "EDGE_SE3:QUAT 0 7 0 0 0 0 0 0 1 1 0 0 0 0 0 1 0 0 0 0 1 0 0 0 1 0 0 1 0 1\n",
       ":2: edge refers to a vertex"}};
  for (const auto& [content, message] : cases) {
    const auto file = folder.write("bad.g2o", content);
    try {
      read_g2o(file);
      FAIL() << content;
    } catch (const InputError& error) {
      EXPECT_NE(std::string(error.what()).find(message), std::string::npos) << error.what();
    }
  }
}

}  // namespace
}  // namespace imslam::pgo
