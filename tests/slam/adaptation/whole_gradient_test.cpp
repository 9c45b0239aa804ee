#include "slam/adaptation/whole_gradient.hpp"

#include <gtest/gtest.h>

#include "slam/system/slam_lower_problem.hpp"
#include "tests/slam/system/contradictory_graph.hpp"

namespace imslam::adaptation {
namespace {

constexpr std::size_t kEdge = 2;

AdaptationOptions published(const std::string& strategy) {
  AdaptationOptions options;
  options.upper = "published";
  options.strategy = strategy;
  options.published_weight = 4.0;
  return options;
}

/// The published cost after solving anew with one motion turned by tau.
double cost_with(const pgo::PoseVelocityGraph& graph, const lie::SE3d::Tangent& tau) {
  system::SlamUpperOptions upper;
  upper.kind = system::UpperKind::kPublished;
  upper.published_weight = 4.0;
  system::SlamLowerProblem problem(graph.data(), graph.options(), {}, upper);
  RelativeMotion motion = graph.visual_edges()[kEdge].motion;
  motion.T_body0_body1 = motion.T_body0_body1 * lie::SE3d::exp(tau);
  auto z = problem.coordinates().origin();
  z.segment<6>(problem.coordinates().visual(kEdge)) =
      problem.coordinates().visual_numbers(kEdge, motion).head<6>();
  EXPECT_TRUE(problem.solve(z).converged);
  return problem.upper_cost().cost;
}

class WholeGradients : public ::testing::Test {
 protected:
  void SetUp() override { ASSERT_TRUE(graph_.solve().converged); }

  lie::SE3d::Tangent slope(const std::string& strategy) const {
    std::string reason;
    const auto whole = WholeGradient::of(graph_, published(strategy), reason);
    EXPECT_TRUE(whole) << reason;
    return whole ? whole->visual(kEdge).by_motion : lie::SE3d::Tangent::Zero();
  }

  pgo::PoseVelocityGraph graph_ = system::testing::contradictory_graph(12, true);
};

TEST_F(WholeGradients, ImplicitIsTheDerivativeThroughTheSolver) {
  constexpr double kStep = 1e-4;
  const lie::SE3d::Tangent implicit = slope("implicit");
  for (int i = 0; i < 6; ++i) {
    const lie::SE3d::Tangent step = kStep * lie::SE3d::Tangent::Unit(i);
    const double numeric = (cost_with(graph_, step) - cost_with(graph_, -step)) / (2.0 * kStep);
    EXPECT_NEAR(implicit[i], numeric, 1e-4 * implicit.norm()) << i;
  }
}

TEST_F(WholeGradients, OneStepIsNotBecauseThePublishedCostIsNotTheGraphs) {
  const lie::SE3d::Tangent implicit = slope("implicit");
  EXPECT_GT((slope("one_step") - implicit).norm(), 0.1 * implicit.norm());
}

TEST(FinetuneOptions, ImplicitIsOnlyForAnUpperCostThatNeedsIt) {
  AdaptationOptions options = published("implicit");
  EXPECT_NO_THROW(options.validate());
  options.upper = "joint";
  EXPECT_THROW(options.validate(), InputError);
}

}  // namespace
}  // namespace imslam::adaptation
