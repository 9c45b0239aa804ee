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
  options.linear_tolerance = 1e-9;  // products are central differences themselves
  return options;
}

SlamUpperOptions as_published() {
  SlamUpperOptions options;
  options.kind = UpperKind::kPublished;
  options.published_weight = 4.0;
  return options;
}

SlamLowerProblem problem_of(const pgo::PoseVelocityGraph& graph, const SlamUpperOptions& upper = {}) {
  return SlamLowerProblem(graph.data(), graph.options(), {}, upper);
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
  for (const std::size_t edge : {std::size_t{2}, kOutlier, std::size_t{8}}) {
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

TEST(SlamLowerProblem, SolvesToRoundingErrorWhereTheDefaultStopsEarlier) {
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

}  // namespace
}  // namespace imslam::system
