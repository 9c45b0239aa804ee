#include <gtest/gtest.h>

#include <cmath>

#include "tests/slam/system/contradictory_problem.hpp"

// Where the covariances go that an upper cost is left alone with.

namespace imslam::system {
namespace {

using learner::Vector;
using testing::contradictory_graph;
using testing::gradient_by;
using testing::kStates;
using testing::problem_of;

/// dU/dlog s where the sigmas of the edges in [first, end) of z are s times the stated ones.
double slope_by_edge_scale(SlamLowerProblem& task, double s, Eigen::Index first, Eigen::Index end) {
  Vector z = task.coordinates().origin();
  z.segment(first, end - first) *= s * s;  // tau = 0, S = I
  task.restart();
  const Vector gradient = gradient_by("implicit_direct", task, z).gradient;
  return 2.0 * gradient.segment(first, end - first).dot(z.segment(first, end - first));
}

/// The same for all bias priors.
double slope_by_prior_scale(SlamLowerProblem& task, double s) {
  Vector direction = Vector::Zero(task.coordinates().size());
  for (const std::size_t k : {0U, 1U}) {
    direction.segment<6>(task.coordinates().bias_prior(k) + 6).setOnes();
  }
  task.restart();
  const Vector z = task.coordinates().origin() + std::log(s) * direction;
  return gradient_by("one_step", task, z).gradient.dot(direction);
}

/// Where a slope that is negative at `low` and positive at `high` changes its sign.
template <typename Slope>
double least_of(const Slope& slope, double low, double high) {
  EXPECT_LT(slope(low), 0.0);
  EXPECT_GT(slope(high), 0.0);
  for (int i = 0; i < 12; ++i) {
    const double middle = std::sqrt(low * high);
    (slope(middle) < 0.0 ? low : high) = middle;
  }
  return low;
}

// Without the log-determinants the slope would be negative everywhere: larger is always better. The
// states follow the noise, so what is left of it is less than the noise itself, unless the states
// are integrated out.
TEST(SlamCovariances, CovariancesOfAllEdgesTogetherNeitherCollapseNorGrow) {
  SlamUpperOptions marginal;
  marginal.kind = UpperKind::kMarginal;
  SlamLowerProblem at_best = problem_of(contradictory_graph(30, true));
  SlamLowerProblem integrated = problem_of(contradictory_graph(30, true), marginal);
  const auto least = [](SlamLowerProblem& task) {
    return least_of(
        [&](double s) { return slope_by_edge_scale(task, s, 0, task.coordinates().bias_prior(0)); },
        0.1, 10.0);
  };
  const double scale = least(at_best);
  const double scale_integrated = least(integrated);
  std::printf(
      "all edges: U is least at %.2f times the sigmas of the noise, states integrated out "
      "at %.2f\n",
      scale, scale_integrated);
  EXPECT_LT(scale, 0.8);
  EXPECT_NEAR(scale_integrated, 1.0, 0.1);
}

// An edge that the states can meet exactly: its likelihood at the best states knows no bound.
TEST(SlamCovariances, TheCovarianceOfOneEdgeCollapsesUnlessTheStatesAreIntegratedOut) {
  SlamUpperOptions marginal;
  marginal.kind = UpperKind::kMarginal;
  for (const bool integrated : {false, true}) {
    SlamLowerProblem task =
        problem_of(contradictory_graph(kStates, true), integrated ? marginal : SlamUpperOptions{});
    const Eigen::Index edge = task.coordinates().visual(6);
    const double slope =
        slope_by_edge_scale(task, 0.02, edge, edge + MeasurementCoordinates::kVisual);
    std::printf("one edge at 0.02 of its sigmas: dU/dlog(sigma) %.2f%s\n", slope,
                integrated ? ", states integrated out" : "");
    if (integrated) {
      EXPECT_LT(slope, 0.1);
    } else {
      EXPECT_GT(slope, 5.0);  // 6 log-determinants, and nothing that holds against them
    }
  }
}

TEST(SlamCovariances, SigmasOfBiasPriorsGoWhereThePriorsErrorsAre) {
  pgo::PoseVelocityGraph graph = contradictory_graph(kStates, true);
  constexpr double kError = 0.4;  // what the data say plainly
  for (pgo::BiasPrior& prior : graph.data().bias_priors) {
    prior.bias = {Eigen::Vector3d::Constant(kError), Eigen::Vector3d::Constant(-kError)};
    prior.sigma = {Eigen::Vector3d::Constant(kError), Eigen::Vector3d::Constant(kError)};
  }
  SlamLowerProblem task = problem_of(graph);
  const double scale = least_of([&](double s) { return slope_by_prior_scale(task, s); }, 0.5, 10.0);
  std::printf("bias priors: U is least at %.2f times their error\n", scale);
  EXPECT_NEAR(scale, 1.0, 0.2);
}

}  // namespace
}  // namespace imslam::system
