#include "slam/adaptation/whole_gradient.hpp"

#include <gtest/gtest.h>

#include <algorithm>

#include "slam/base/time.hpp"
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

/// The upper cost after solving anew with one motion turned by tau.
double cost_with(const pgo::PoseVelocityGraph& graph,
                 const system::SlamUpperOptions& upper,
                 const lie::SE3d::Tangent& tau) {
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

  lie::SE3d::Tangent slope(const system::SlamUpperOptions& upper,
                           const std::string& strategy) const {
    std::string reason;
    const auto whole = WholeGradient::of(graph_, upper, strategy, reason);
    EXPECT_TRUE(whole) << reason;
    return whole ? whole->visual(kEdge).by_motion : lie::SE3d::Tangent::Zero();
  }

  void expect_implicit_is_numeric(const system::SlamUpperOptions& upper) const {
    constexpr double kStep = 1e-4;
    const lie::SE3d::Tangent implicit = slope(upper, "implicit");
    EXPECT_GT(implicit.norm(), 1e-3);
    for (int i = 0; i < 6; ++i) {
      const lie::SE3d::Tangent step = kStep * lie::SE3d::Tangent::Unit(i);
      const double numeric =
          (cost_with(graph_, upper, step) - cost_with(graph_, upper, -step)) / (2.0 * kStep);
      EXPECT_NEAR(implicit[i], numeric, 1e-4 * implicit.norm()) << i;
    }
  }

  pgo::PoseVelocityGraph graph_ = system::testing::contradictory_graph(12, true);
};

TEST_F(WholeGradients, ImplicitIsTheDerivativeThroughTheSolver) {
  expect_implicit_is_numeric(published_upper(published("implicit")));
}

TEST_F(WholeGradients, OfLoopsFollowsTheStatesToMotionsThatCloseNone) {
  AdaptationOptions options;
  const auto span_s = [this](std::size_t e) {
    const RelativeMotion& motion = graph_.visual_edges()[e].motion;
    return to_seconds(motion.time1_ns - motion.time0_ns);
  };
  double longest_s = 0.0;
  for (std::size_t e = 0; e < graph_.visual_edges().size(); ++e) {
    longest_s = std::max(longest_s, span_s(e));
  }
  options.loop_span_s = longest_s;
  ASSERT_LT(span_s(kEdge), longest_s);
  const auto loops = loop_upper(graph_, options);
  ASSERT_TRUE(loops);
  expect_implicit_is_numeric(*loops);
  EXPECT_EQ(slope(*loops, "one_step").norm(), 0.0) << "held states see no loop in a single step";
  options.loop_span_s = 2.0 * longest_s;
  EXPECT_FALSE(loop_upper(graph_, options));
}

TEST_F(WholeGradients, OneStepIsNotBecauseThePublishedCostIsNotTheGraphs) {
  const lie::SE3d::Tangent implicit = slope(published_upper(published("implicit")), "implicit");
  EXPECT_GT((slope(published_upper(published("one_step")), "one_step") - implicit).norm(),
            0.1 * implicit.norm());
}

TEST(FinetuneOptions, ImplicitIsOnlyForAnUpperCostThatNeedsIt) {
  AdaptationOptions options = published("implicit");
  EXPECT_NO_THROW(options.validate());
  options.upper = "joint";
  EXPECT_THROW(options.validate(), InputError);
}

}  // namespace
}  // namespace imslam::adaptation
