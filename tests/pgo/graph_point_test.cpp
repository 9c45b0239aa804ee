#include "pgo/graph_point.hpp"

#include <gtest/gtest.h>

#include "pgo/measurement_gradient.hpp"
#include "pgo/pose_velocity_graph.hpp"
#include "tests/slam/system/contradictory_graph.hpp"
#include "tests/support/numeric_jacobian.hpp"

namespace imslam::pgo {
namespace {

using Eigen::VectorXd;
using imslam::system::testing::contradictory_graph;

class GraphPointTest : public ::testing::Test {
 protected:
  /// A part of the likelihood at mu Exp(tau).
  template <typename Part>
  VectorXd slope_by_differences(const Part& part) {
    const VectorXd start = point_.numbers();
    const auto cost = [&](const VectorXd& tau) -> VectorXd {
      point_.set_numbers(start);
      point_.move(tau);
      PoseVelocityGraph moved = graph_;
      EXPECT_TRUE(point_.store(moved.data()));
      return VectorXd::Constant(1, part(moved));
    };
    const VectorXd slope =
        testing::numeric_jacobian(cost, VectorXd::Zero(point_.size()), 1e-7).transpose();
    point_.set_numbers(start);
    return slope;
  }

  PoseVelocityGraph graph_ = contradictory_graph(5, true);
  GraphPoint point_{graph_.data(), graph_.options()};
};

TEST_F(GraphPointTest, GradientMatchesCentralDifferences) {
  const VectorXd gradient = point_.gradient();
  ASSERT_EQ(gradient.size(), 5 * 15 + 8);
  const VectorXd numeric =
      slope_by_differences([](const PoseVelocityGraph& graph) { return graph.cost(); });
  EXPECT_LT((gradient - numeric).norm(), 1e-6 * numeric.norm());
}

TEST_F(GraphPointTest, GradientOfSomeEdgesIsThatOfTheirParts) {
  EdgeSelection some{std::vector<char>(graph_.visual_edges().size()),
                     std::vector<char>(graph_.inertial_edges().size())};
  some.visual[1] = some.visual[3] = some.inertial[2] = 1;
  const VectorXd numeric = slope_by_differences([](const PoseVelocityGraph& graph) {
    const NegativeLogLikelihood parts = negative_log_likelihood(graph);
    return parts.visual[1] + parts.visual[3] + parts.inertial[2];
  });
  EXPECT_LT((point_.gradient(some) - numeric).norm(), 1e-6 * numeric.norm());
  const EdgeSelection none{std::vector<char>(some.visual.size()),
                           std::vector<char>(some.inertial.size())};
  EXPECT_TRUE(point_.gradient(none).isZero(0.0));
}

TEST_F(GraphPointTest, NumbersBringAPointBackExactly) {
  const VectorXd gradient = point_.gradient();
  const VectorXd start = point_.numbers();
  point_.move(VectorXd::Constant(point_.size(), 0.1));
  EXPECT_GT((point_.gradient() - gradient).norm(), 1.0);
  point_.set_numbers(start);
  EXPECT_EQ(point_.gradient(), gradient);
}

TEST_F(GraphPointTest, BlocksHaveAPlaceInTheTangentIfTheyAreEstimated) {
  EXPECT_EQ(point_.offset({BlockId::Kind::kPose, 0}), 0);
  EXPECT_EQ(point_.offset({BlockId::Kind::kVelocity, 2}), 2 * 15 + 6);
  EXPECT_EQ(point_.offset({BlockId::Kind::kGravity, 0}), 5 * 15);
  const PoseVelocityGraph vision = contradictory_graph(5, false);
  const GraphPoint poses(vision.data(), vision.options());
  EXPECT_EQ(poses.size(), 5 * 6 + 1);
  EXPECT_EQ(poses.offset({BlockId::Kind::kVelocity, 2}), -1);
}

}  // namespace
}  // namespace imslam::pgo
