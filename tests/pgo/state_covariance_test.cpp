#include <gtest/gtest.h>

#include "pgo/linear_system.hpp"
#include "pgo/pose_velocity_graph.hpp"
#include "pgo/selected_inverse.hpp"
#include "tests/pgo/synthetic.hpp"
#include "tests/support/numeric_jacobian.hpp"

namespace imslam::pgo {
namespace {

using testing::chain_graph;
using testing::expect_near;
using testing::wavy_states;

TEST(SelectedInverse, MatchesTheDenseInverseOnThePattern) {
  Random random(1);
  const int size = 40;
  Eigen::MatrixXd A = Eigen::MatrixXd::Identity(size, size) * 3.0;
  for (int k = 0; k < 60; ++k) {
    const auto i = random.integer(0, size - 1);
    const auto j = random.integer(0, size - 1);
    A(i, j) += random.normal();
  }
  const Eigen::MatrixXd H = A.transpose() * A;
  const Eigen::SparseMatrix<double> sparse = H.sparseView();
  const auto inverse = SelectedInverse::factorize(sparse);
  ASSERT_TRUE(inverse);
  const Eigen::MatrixXd expected = H.inverse();
  for (int i = 0; i < size; ++i) {
    for (int j = 0; j < size; ++j) {
      if (H(i, j) == 0.0) continue;
      EXPECT_NEAR((*inverse)(i, j), expected(i, j), 1e-12);
    }
  }
}

TEST(SelectedInverse, RefusesASingularMatrix) {
  Eigen::Matrix2d H;
  H << 1.0, 1.0, 1.0, 1.0;
  EXPECT_FALSE(SelectedInverse::factorize(Eigen::SparseMatrix<double>(H.sparseView())));
}

TEST(PoseVelocityGraph, CovariancesMatchTheDenseInverse) {
  GraphOptions options;
  options.estimate_time_offset = true;
  PoseVelocityGraph graph = chain_graph(wavy_states(6), options, true, 0.0);
  graph.add_time_offset_prior(0.0, 0.01);
  graph.data().inertial_edges[2].motion.J_time_offset.setConstant(0.3);
  const auto covariances = graph.covariances();
  ASSERT_TRUE(covariances);

  GraphProblem problem(graph.data(), graph.options());
  const LinearSystem system = linearize(problem, estimated_blocks(problem, 6));
  const Eigen::MatrixXd J(system.J);
  ASSERT_EQ(J.cols(), 6 * 15 + 1);
  const Eigen::MatrixXd expected =
      (J.transpose() * J).ldlt().solve(Eigen::MatrixXd::Identity(J.cols(), J.cols()));
  for (int i = 0; i < 6; ++i) {
    const Eigen::MatrixXd block = expected.block<15, 15>(15 * i, 15 * i);
    const Eigen::VectorXd sigma = block.diagonal().cwiseSqrt().cwiseInverse();
    const Eigen::MatrixXd actual = (*covariances)[static_cast<std::size_t>(i)];
    expect_near(sigma.asDiagonal() * actual * sigma.asDiagonal(),
                sigma.asDiagonal() * block * sigma.asDiagonal(), 1e-6);
    expect_near(*graph.covariance(i), actual, 1e-9);
  }
}

TEST(PoseVelocityGraph, CovarianceOfAChainGrowsByTheEdges) {
  PoseVelocityGraph graph;
  for (int i = 0; i < 4; ++i) {
    State state;
    state.time_ns = i;
    graph.add_state(state);
    RelativeMotion still;
    still.covariance *= 1e-4;
    if (i == 0) continue;
    ASSERT_TRUE(graph.add_visual_edge(i - 1, i, still));
  }
  graph.anchor_pose(0, lie::SE3d());
  const auto covariances = graph.covariances();
  ASSERT_TRUE(covariances);
  for (int i = 0; i < 4; ++i) {
    const auto& covariance = (*covariances)[static_cast<std::size_t>(i)];
    EXPECT_NEAR(covariance(5, 5), 1e-4 * i + 1e-10, 1e-12);
    EXPECT_EQ(covariance(6, 6), 0.0);  // velocities are not estimated without IMU
  }
}

TEST(PoseVelocityGraph, HasNoCovarianceWhereTheGraphDoesNotDetermineTheStates) {
  PoseVelocityGraph graph;
  EXPECT_FALSE(graph.covariances());
  const auto truth = wavy_states(3);
  graph = chain_graph(truth, {}, true, 0.0);
  graph.data().anchors.clear();
  EXPECT_FALSE(graph.covariances());
  // Anchored, but nothing tells the accelerometer bias of so short a graph without its prior.
  graph = chain_graph(wavy_states(2), {}, true, 0.0);
  graph.data().bias_priors.clear();
  graph.data().visual_edges.clear();
  EXPECT_FALSE(graph.covariances());
}

TEST(PoseVelocityGraph, CovariancesOfTenThousandStatesAreFeasible) {
  PoseVelocityGraph graph = chain_graph(wavy_states(10000, 0.01), {}, true, 0.0);
  const auto covariances = graph.covariances();
  ASSERT_TRUE(covariances);
  for (const auto& covariance : *covariances) {
    ASSERT_TRUE(covariance.allFinite());
    ASSERT_GT(covariance.diagonal().minCoeff(), 0.0);
  }
  EXPECT_GT(covariances->back()(0, 0), (*covariances)[100](0, 0));
}

}  // namespace
}  // namespace imslam::pgo
