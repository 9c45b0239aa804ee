#include "slam/system/measurement_coordinates.hpp"

#include <gtest/gtest.h>

#include "tests/slam/system/contradictory_graph.hpp"

namespace imslam::system {
namespace {

using Eigen::VectorXd;
using testing::contradictory_graph;
using testing::random_covariance;
using testing::random_matrix;

/// What a network says about an edge, near what was measured.
template <int kSize, typename Motion>
Motion with_covariance(Motion motion, Random& random) {
  motion.covariance = random_covariance<kSize>(random, 0.03);
  return motion;
}

TEST(MeasurementCoordinates, WhatANetworkSaysComesBackFromItsNumbers) {
  pgo::GraphData data = contradictory_graph(6, true).data();
  const MeasurementCoordinates coordinates(data);
  Random random(1);
  RelativeMotion visual = with_covariance<6>(data.visual_edges[2].motion, random);
  visual.T_body0_body1 = visual.T_body0_body1 * lie::SE3d::exp(0.1 * random_matrix<6, 1>(random));
  ImuMotion inertial = with_covariance<9>(data.inertial_edges[3].motion, random);
  inertial.dR = inertial.dR * lie::SO3d::exp(0.1 * random.normal3());
  inertial.dv += random.normal3();

  VectorXd z = coordinates.origin();
  z.segment<MeasurementCoordinates::kVisual>(coordinates.visual(2)) =
      coordinates.visual_numbers(2, visual);
  z.segment<MeasurementCoordinates::kInertial>(coordinates.inertial(3)) =
      coordinates.inertial_numbers(3, inertial);
  ASSERT_EQ(coordinates.apply(z, data), "");
  const auto& edge = data.visual_edges[2];
  EXPECT_TRUE(edge.motion.T_body0_body1.matrix().isApprox(visual.T_body0_body1.matrix(), 1e-12));
  EXPECT_TRUE(edge.motion.covariance.isApprox(visual.covariance, 1e-9));
  EXPECT_TRUE((edge.sqrt_information.transpose() * edge.sqrt_information * visual.covariance)
                  .isIdentity(1e-9));
  EXPECT_TRUE(edge.sqrt_information.isLowerTriangular());
  EXPECT_TRUE(data.inertial_edges[3].motion.dR.matrix().isApprox(inertial.dR.matrix(), 1e-12));
  EXPECT_TRUE(data.inertial_edges[3].motion.dv.isApprox(inertial.dv, 1e-12));
  EXPECT_TRUE(data.inertial_edges[3].motion.covariance.isApprox(inertial.covariance, 1e-9));
}

TEST(MeasurementCoordinates, TheWayBackIsTheInverseOfThePullBack) {
  const pgo::GraphData data = contradictory_graph(6, true).data();
  const MeasurementCoordinates coordinates(data);
  Random random(2);
  VectorXd z = coordinates.origin();
  for (double& number : z) number += 0.05 * random.normal();
  const auto gradient = [&] {
    pgo::PoseVelocityGraph graph = contradictory_graph(6, true);
    EXPECT_EQ(coordinates.apply(z, graph.data()), "");
    return pgo::measurement_gradient(graph, true);
  }();
  const VectorXd dz = coordinates.pull_back(z, gradient);
  const auto visual = coordinates.visual_gradient(1, z, dz);
  EXPECT_TRUE(visual.motion.isApprox(gradient.visual[1].motion, 1e-10));
  EXPECT_TRUE(visual.covariance.isApprox(gradient.visual[1].covariance, 1e-10));
  const auto inertial = coordinates.inertial_gradient(4, z, dz);
  EXPECT_TRUE(inertial.motion.isApprox(gradient.inertial[4].motion, 1e-10));
  EXPECT_TRUE(inertial.covariance.isApprox(gradient.inertial[4].covariance, 1e-10));
}

}  // namespace
}  // namespace imslam::system
