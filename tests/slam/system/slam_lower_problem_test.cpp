#include "slam/system/slam_lower_problem.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <map>

#include "pgo/measurement_gradient.hpp"
#include "slam/learner/make_strategy.hpp"
#include "slam/system/batch_estimator.hpp"
#include "tests/slam/system/contradictory_problem.hpp"
#include "tests/slam/system/sine_measurements.hpp"

namespace imslam::system {
namespace {

using learner::UpperGradient;
using learner::Vector;
using testing::as_published;
using testing::contradictory_graph;
using testing::gradient_by;
using testing::kOutlier;
using testing::kStates;
using testing::named;
using testing::problem_of;

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
  for (const std::size_t prior : {0U, 1U}) {
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

// Sigmas of an IMU and of good vision: weights of up to 1e5, covariances that are nearly singular.
TEST(SlamLowerProblem, TheGraphOfARunIsSolvedAndDifferentiatedToo) {
  Measurements measurements = testing::SineWorld().measure();
  Random random(6);
  for (RelativeMotion& motion : measurements.odometry) {
    motion.T_body0_body1 =
        motion.T_body0_body1 * lie::SE3d::exp(testing::drawn_from<6>(motion.covariance, random));
  }
  const BatchEstimate run = estimate_batch(measurements, Estimate{0.0, 2.0}, {});
  ASSERT_TRUE(run.inertial);
  SlamLowerProblem task(run.graph, run.graph_options, {}, as_published());
  const UpperGradient upper = gradient_by("implicit_direct", task, task.coordinates().origin());
  std::printf("graph of a run: |dL/dphi| %.1e, linear residual %.1e %s\n", upper.residual,
              upper.linear.residual, upper.note.c_str());
  EXPECT_EQ(upper.note, "");
  EXPECT_NEAR(task.graph().cost(), run.report.cost, 1e-6 * run.report.cost);
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
  for (const std::size_t e : {2U, 3U, 5U, 8U}) upper.only->visual[e] = 1;
  for (const std::size_t e : {4U, 6U}) upper.only->inertial[e] = 1;
  // Pulls the last position to the origin, and the first number of z to 0.
  Eigen::Index at = 0;
  upper.extra = [&at](const pgo::GraphData& solved, const Vector& z) {
    const lie::SE3d& pose = solved.states.back().nav.T_world_body;
    learner::UpperValue value{0.5 * pose.translation().squaredNorm() + 0.5 * z(0) * z(0),
                              z(0) * Vector::Unit(z.size(), 0), Vector::Zero(at + 15 + 8)};
    value.by_phi.segment<3>(at) = pose.rotation().matrix().transpose() * pose.translation();
    return value;
  };
  SlamLowerProblem task = problem_of(graph, upper);
  at = task.point().offset({pgo::BlockId::Kind::kPose, kStates - 1});
  ASSERT_EQ(task.point().size(), at + 15 + 8);  // gravity 2, three scalars, turn of the camera 3
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
