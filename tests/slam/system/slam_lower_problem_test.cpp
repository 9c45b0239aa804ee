#include "slam/system/slam_lower_problem.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <map>

#include "pgo/measurement_gradient.hpp"
#include "slam/learner/make_strategy.hpp"
#include "tests/slam/system/contradictory_graph.hpp"

namespace imslam::system {
namespace {

using learner::GradientStrategy;
using learner::UpperGradient;
using learner::Vector;
using testing::contradictory_graph;
using testing::kOutlier;

constexpr int kStates = 12;

learner::StrategyOptions named(const std::string& name) {
  learner::StrategyOptions options;
  options.strategy = name;
  options.tolerance = 1e-9;
  options.linear_tolerance = 1e-7;  // products are central differences themselves
  return options;
}

SlamUpperOptions as_published() {
  SlamUpperOptions options;
  options.kind = UpperKind::kPublished;
  options.published_weight = 4.0;
  return options;
}

SlamLowerProblem problem_of(const pgo::PoseVelocityGraph& graph,
                            const SlamUpperOptions& upper = {}) {
  pgo::SolverOptions solver;
  solver.threads = 1;
  return SlamLowerProblem(graph.data(), graph.options(), solver, upper);
}

UpperGradient gradient_by(const std::string& strategy, SlamLowerProblem& task, const Vector& z) {
  const UpperGradient upper = (*make_strategy(named(strategy), task))(z, Random(0));
  EXPECT_TRUE(upper.usable()) << strategy << ": " << name_of(upper.refusal) << " "
                              << upper.solve.reason << " " << upper.note;
  return upper;
}

/// Entries of z by kind: of an ordinary edge, of the outlier, of an inertial edge, of the priors.
std::map<std::string, std::vector<Eigen::Index>> probes(const SlamLowerProblem& task) {
  const MeasurementCoordinates& z = task.coordinates();
  std::map<std::string, std::vector<Eigen::Index>> entries;
  const auto add = [&entries](const std::string& name, Eigen::Index first, Eigen::Index count) {
    for (Eigen::Index i = 0; i < count; ++i) entries[name].push_back(first + i);
  };
  for (const std::size_t edge : {std::size_t{2}, kOutlier}) {
    const std::string outlier = edge == kOutlier ? "outlier's " : "visual ";
    add(outlier + "motion", z.visual(edge), 6);
    add(outlier + "covariance", z.visual(edge) + 6, 21);
  }
  if (task.graph().inertial_edges().empty()) return entries;
  add("inertial motion", z.inertial(4), 9);
  add("inertial covariance", z.inertial(4) + 9, 45);
  for (const std::size_t prior : {0, 1}) {
    add("bias prior", z.bias_prior(prior), 6);
    add("bias prior's sigma", z.bias_prior(prior) + 6, 6);
  }
  return entries;
}

double relative_error(const Vector& actual, const Vector& expected) {
  return (actual - expected).norm() / expected.norm();
}

/// Against central differences through the whole solve, kind by kind.
void expect_true_gradient(const std::string& strategy, SlamLowerProblem& task, const Vector& z) {
  constexpr double kStep = 1e-4;
  const UpperGradient upper = gradient_by(strategy, task, z);
  std::printf("%s, gradient of the solve %.0e, linear residual %.0e\n", strategy.c_str(),
              upper.residual, upper.linear.residual);
  for (const auto& [name, entries] : probes(task)) {
    const auto count = static_cast<Eigen::Index>(entries.size());
    Vector analytic(count);
    Vector numeric(count);
    for (Eigen::Index i = 0; i < count; ++i) {
      const Eigen::Index entry = entries[static_cast<std::size_t>(i)];
      const Vector step = kStep * Vector::Unit(z.size(), entry);
      analytic(i) = upper.gradient(entry);
      numeric(i) = (gradient_by("alternating", task, z + step).cost -
                    gradient_by("alternating", task, z - step).cost) /
                   (2.0 * kStep);
    }
    const double error = relative_error(analytic, numeric);
    std::printf("  %-22s %.1e\n", name.c_str(), error);
    EXPECT_LE(error, 1e-6) << name;
  }
}

/// A point beside the origin, so that tau != 0 and S != I.
Vector beside_origin(const SlamLowerProblem& task) {
  Random random(3);
  Vector z = task.coordinates().origin();
  for (double& number : z) number += 0.01 * random.normal();
  return z;
}

TEST(SlamLowerProblem, TheOriginIsTheGraphItself) {
  const auto graph = contradictory_graph(kStates, true);
  SlamLowerProblem task = problem_of(graph);
  EXPECT_TRUE(task.solve(task.coordinates().origin()).converged);
  for (std::size_t e = 0; e < graph.visual_edges().size(); ++e) {
    EXPECT_TRUE(task.graph().visual_edges()[e].sqrt_information.isApprox(
        graph.visual_edges()[e].sqrt_information, 1e-12));
    EXPECT_TRUE(task.graph().visual_edges()[e].motion.covariance.isApprox(
        graph.visual_edges()[e].motion.covariance, 1e-12));
  }
  EXPECT_GT(task.graph().cost(), 10.0);
  pgo::PoseVelocityGraph solved = graph;
  solved.solve();
  EXPECT_NEAR(task.graph().cost(), solved.cost(), 1e-6 * solved.cost());
}

TEST(SlamLowerProblem, SolvesToRoundingError) {
  SlamLowerProblem task = problem_of(contradictory_graph(kStates, true));
  const SolveReport report = task.solve(task.coordinates().origin());
  std::printf("%d steps, |dL/dphi| %.1e\n", report.iterations, report.gradient_norm);
  EXPECT_LT(report.gradient_norm, 1e-10);
}

TEST(SlamLowerProblem, OneStepIsTrueWhenTheUpperCostIsTheLower) {
  for (const bool inertial : {true, false}) {
    SlamLowerProblem task = problem_of(contradictory_graph(kStates, inertial));
    expect_true_gradient("one_step", task, beside_origin(task));
  }
}

TEST(SlamLowerProblem, ImplicitIsTrueWhenTheUpperCostIsThePublished) {
  for (const bool inertial : {true, false}) {
    SlamLowerProblem task = problem_of(contradictory_graph(kStates, inertial), as_published());
    expect_true_gradient("implicit_direct", task, beside_origin(task));
  }
}

TEST(SlamLowerProblem, ImplicitIsOneStepWhenTheUpperCostIsTheLower) {
  SlamLowerProblem task = problem_of(contradictory_graph(kStates, true));
  const Vector z = beside_origin(task);
  const UpperGradient one_step = gradient_by("one_step", task, z);
  const UpperGradient implicit = gradient_by("implicit_direct", task, z);
  const double apart = relative_error(implicit.gradient, one_step.gradient);
  std::printf("U = L: implicit and one step are %.1e apart\n", apart);
  EXPECT_LT(apart, 1e-12);
  EXPECT_NEAR(implicit.cost, one_step.cost, 1e-9 * std::abs(one_step.cost));
}

// What the published method does.
TEST(SlamLowerProblem, OneStepIsWrongWhenTheUpperCostIsThePublished) {
  for (const bool inertial : {true, false}) {
    SlamLowerProblem task = problem_of(contradictory_graph(kStates, inertial), as_published());
    const Vector z = task.coordinates().origin();
    const UpperGradient exact = gradient_by("implicit_direct", task, z);
    EXPECT_EQ(exact.note, "");
    const Eigen::Index motions = task.coordinates().inertial(0);
    for (const char* name : {"one_step", "alternating"}) {
      const Vector wrong = gradient_by(name, task, z).gradient;
      const Vector of_vision = wrong.head(motions);
      const Vector exact_of_vision = exact.gradient.head(motions);
      const double angle_deg =
          std::acos(of_vision.normalized().dot(exact_of_vision.normalized())) * 180.0 / M_PI;
      const double size = of_vision.norm() / exact_of_vision.norm();
      std::printf("published U, %s, %s: %.0f degrees beside dU/dz of vision, %.2f times as long\n",
                  inertial ? "with IMU" : "vision only", name, angle_deg, size);
      EXPECT_GT(relative_error(wrong, exact.gradient), 0.1);
    }
  }
}

TEST(SlamLowerProblem, HessianIsSymmetricAndNearTheIdentity) {
  SlamLowerProblem task = problem_of(contradictory_graph(kStates, true));
  task.solve(task.coordinates().origin());
  Random random(9);
  Vector a(task.point().size());
  Vector b(task.point().size());
  for (double& x : a) x = random.normal();
  for (double& x : b) x = random.normal();
  const Vector Ha = task.hessian_product(a);
  EXPECT_NEAR(b.dot(Ha), a.dot(task.hessian_product(b)), 1e-7 * a.norm() * b.norm());
  EXPECT_LT(relative_error(Ha, a), 0.5);
  const auto q = task.hessian_solve(Ha);
  ASSERT_TRUE(q);
  EXPECT_LT(relative_error(*q, a), 1e-7);
}

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
  for (const std::size_t k : {0, 1}) {
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
TEST(SlamLowerProblem, CovariancesOfAllEdgesTogetherNeitherCollapseNorGrow) {
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
TEST(SlamLowerProblem, TheCovarianceOfOneEdgeCollapsesUnlessTheStatesAreIntegratedOut) {
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

TEST(SlamLowerProblem, SigmasOfBiasPriorsGoWhereThePriorsErrorsAre) {
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

TEST(SlamLowerProblem, ACovarianceThatIsNotPositiveIsNoSolve) {
  SlamLowerProblem task = problem_of(contradictory_graph(kStates, true));
  Vector z = task.coordinates().origin();
  z(task.coordinates().visual(3) + 6) = -1.0;
  const SolveReport report = task.solve(z);
  EXPECT_FALSE(report.converged);
  EXPECT_NE(report.reason.find("visual edge 3"), std::string::npos) << report.reason;
  const UpperGradient upper = (*make_strategy(named("one_step"), task))(z, Random(0));
  EXPECT_EQ(upper.refusal, learner::Refusal::kUnconverged);
}

TEST(SlamLowerProblem, ARestartForgetsEarlierSolvesBitByBit) {
  SlamLowerProblem task = problem_of(contradictory_graph(kStates, true));
  const Vector z = beside_origin(task);
  const Vector first = gradient_by("one_step", task, z).gradient;
  gradient_by("one_step", task, task.coordinates().origin());
  task.restart();
  EXPECT_EQ(gradient_by("one_step", task, z).gradient, first);
}

TEST(SlamUpperCost, SomeEdgesOnlyAndATermOfTheCallersGoThroughTheSolve) {
  const auto graph = contradictory_graph(kStates, true);
  SlamUpperOptions upper;
  upper.only = pgo::EdgeSelection{std::vector<char>(graph.visual_edges().size()),
                                  std::vector<char>(graph.inertial_edges().size())};
  for (const std::size_t e : {2, 3, 5, 8}) upper.only->visual[e] = 1;
  for (const std::size_t e : {4, 6}) upper.only->inertial[e] = 1;
  // Pulls the last position to the origin, and the first number of z to 0.
  Eigen::Index at = 0;
  upper.extra = [&at](const pgo::GraphData& solved, const Vector& z) {
    const lie::SE3d& pose = solved.states.back().nav.T_world_body;
    learner::UpperValue value{0.5 * pose.translation().squaredNorm() + 0.5 * z(0) * z(0),
                              z(0) * Vector::Unit(z.size(), 0), Vector::Zero(at + 15 + 5)};
    value.by_phi.segment<3>(at) = pose.rotation().matrix().transpose() * pose.translation();
    return value;
  };
  SlamLowerProblem task = problem_of(graph, upper);
  at = task.point().offset({pgo::BlockId::Kind::kPose, kStates - 1});
  ASSERT_EQ(task.point().size(), at + 15 + 5);  // gravity 2, three scalars
  expect_true_gradient("implicit_direct", task, beside_origin(task));
}

TEST(SlamUpperCost, TheSelectionOfAllEdgesIsTheGraphWithoutItsPriors) {
  const auto graph = contradictory_graph(kStates, true);
  SlamUpperOptions all;
  all.only = pgo::EdgeSelection{std::vector<char>(graph.visual_edges().size(), 1),
                                std::vector<char>(graph.inertial_edges().size(), 1)};
  SlamLowerProblem some = problem_of(graph, all);
  SlamLowerProblem whole = problem_of(graph);
  some.solve(some.coordinates().origin());
  whole.solve(whole.coordinates().origin());
  const auto parts = pgo::negative_log_likelihood(whole.graph());
  double priors = parts.rest;
  for (const double part : parts.bias_priors) priors += part;
  EXPECT_NEAR(some.upper_cost().cost + priors, whole.upper_cost().cost, 1e-9);
  const Eigen::Index edges = some.coordinates().bias_prior(0);
  EXPECT_TRUE(some.upper_cost().by_z.head(edges).isApprox(whole.upper_cost().by_z.head(edges)));
}

}  // namespace
}  // namespace imslam::system
