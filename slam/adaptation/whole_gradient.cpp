#include "slam/adaptation/whole_gradient.hpp"

#include <algorithm>
#include <utility>
#include <vector>

#include "slam/base/time.hpp"
#include "slam/learner/make_strategy.hpp"
#include "slam/system/slam_lower_problem.hpp"

namespace imslam::adaptation {
namespace {

/// As exact as the products of SlamLowerProblem are.
constexpr double kLinearTolerance = 1e-7;

struct Slopes {
  double cost = 0.0;
  Eigen::VectorXd by_z;
};

std::optional<Slopes> implicit_slopes(system::SlamLowerProblem& problem,
                                      const Eigen::VectorXd& z,
                                      std::string& reason) {
  learner::StrategyOptions options;
  options.strategy = "implicit_direct";
  options.linear_tolerance = kLinearTolerance;
  const auto strategy = learner::make_strategy(options, problem);
  learner::UpperGradient gradient = (*strategy)(z, Random(0));  // it draws nothing
  if (gradient.usable()) return Slopes{gradient.cost, std::move(gradient.gradient)};
  reason = "no implicit gradient: " + std::string(learner::name_of(gradient.refusal)) +
           (gradient.note.empty() ? "" : ", " + gradient.note);
  return std::nullopt;
}

std::optional<Slopes> held_slopes(system::SlamLowerProblem& problem,
                                  const Eigen::VectorXd& z,
                                  std::string& reason) {
  if (!problem.solve(z).converged) {
    reason = "the graph does not converge to rounding errors";
    return std::nullopt;
  }
  learner::UpperValue upper = problem.upper_cost();
  return Slopes{upper.cost, std::move(upper.by_z)};
}

}  // namespace

WholeGradient::WholeGradient(system::MeasurementCoordinates coordinates,
                             Eigen::VectorXd z,
                             Eigen::VectorXd dz,
                             double cost_per_edge)
    : coordinates_(std::move(coordinates)),
      z_(std::move(z)),
      dz_(std::move(dz)),
      cost_per_edge_(cost_per_edge) {}

std::optional<WholeGradient> WholeGradient::of(const pgo::PoseVelocityGraph& solved,
                                               const system::SlamUpperOptions& upper,
                                               const std::string& strategy,
                                               std::string& reason) {
  system::SlamLowerProblem problem(solved.data(), solved.options(), {}, upper);
  const Eigen::VectorXd z = problem.coordinates().origin();
  const auto slopes = strategy == "implicit" ? implicit_slopes(problem, z, reason)
                                             : held_slopes(problem, z, reason);
  if (!slopes) return std::nullopt;
  const auto edges = static_cast<double>(std::max<std::size_t>(1, solved.visual_edges().size()));
  return WholeGradient(problem.coordinates(), z, slopes->by_z, slopes->cost / edges);
}

vo::MotionSlope WholeGradient::visual(std::size_t edge) const {
  const auto gradient = coordinates_.visual_gradient(edge, z_, dz_);
  return {cost_per_edge_, gradient.motion, gradient.covariance};
}

pgo::EdgeLikelihood<9> WholeGradient::inertial(std::size_t edge) const {
  return {cost_per_edge_, coordinates_.inertial_gradient(edge, z_, dz_)};
}

system::SlamUpperOptions published_upper(const AdaptationOptions& options) {
  system::SlamUpperOptions upper;
  upper.kind = system::UpperKind::kPublished;
  upper.published_weight = options.published_weight;
  return upper;
}

std::optional<system::SlamUpperOptions> loop_upper(const pgo::PoseVelocityGraph& solved,
                                                   const AdaptationOptions& options) {
  const auto& edges = solved.visual_edges();
  pgo::EdgeSelection loops{std::vector<char>(edges.size()),
                           std::vector<char>(solved.inertial_edges().size())};
  bool any = false;
  for (std::size_t e = 0; e < edges.size(); ++e) {
    const RelativeMotion& motion = edges[e].motion;
    if (to_seconds(motion.time1_ns - motion.time0_ns) < options.loop_span_s) continue;
    loops.visual[e] = 1;
    any = true;
  }
  if (!any) return std::nullopt;
  system::SlamUpperOptions upper;
  upper.only = std::move(loops);
  return upper;
}

}  // namespace imslam::adaptation
