#include "slam/system/slam_lower_problem.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

#include "pgo/measurement_gradient.hpp"
#include "slam/base/error.hpp"
#include "slam/learner/linear_solve.hpp"

namespace imslam::system {
namespace {

// Largest |dL/dphi|: of a solution, and where descending ends; then without gain, or at last.
constexpr double kStationary = 1e-7;
constexpr double kAim = 1e-13;
constexpr double kGain = 0.95;
constexpr int kDescents = 100;

/// Relative change of the cost at which the solver hands over to the descent.
constexpr double kHandOver = 1e-4;

// Steps of the differences: in standard deviations of the whole graph's residual, and for the
// largest entry of the tangent. The rule's error is of the fourth order in them; but an edge that
// comes over the kink of Huber's kernel on the way spoils the product, and the solve then says so.
constexpr double kStep = 0.02;
constexpr double kTangentStep = 1e-2;  // [rad], [m], ...

// Of H q = v, relative: what conjugate gradient aims at, and what rounding may leave of it.
constexpr double kLinearAim = 1e-10;
constexpr double kLinearTolerance = 1e-7;
constexpr int kLinearIterations = 100;

pgo::SolverOptions with_hand_over(pgo::SolverOptions options) {
  options.function_tolerance = std::max(options.function_tolerance, kHandOver);
  return options;
}

}  // namespace

SlamLowerProblem::SlamLowerProblem(const pgo::GraphData& data,
                                   const pgo::GraphOptions& graph_options,
                                   const pgo::SolverOptions& solver_options,
                                   const SlamUpperOptions& upper_options)
    : coordinates_(data),
      solver_options_(with_hand_over(solver_options)),
      upper_options_(upper_options),
      first_states_(data.states),
      first_globals_(data.globals),
      graph_(graph_options),
      z_(coordinates_.origin()) {
  graph_.data() = data;
  point_ = std::make_unique<pgo::GraphPoint>(graph_.data(), graph_options);
}

void SlamLowerProblem::restart() {
  graph_.data().states = first_states_;
  graph_.data().globals = first_globals_;
}

SolveReport SlamLowerProblem::solve(const Vector& z) {
  SolveReport report;
  report.reason = set_measurements(z);
  if (!report.reason.empty()) return report;
  report = point_->solve(solver_options_);
  if (!factorize()) {
    report.converged = false;
    report.reason = "the graph does not determine its states: " + report.reason;
    return report;
  }
  report.gradient_norm = descend();
  report.converged = report.gradient_norm <= kStationary && take_states();
  report.cost = graph_.cost();
  return report;
}

std::string SlamLowerProblem::set_measurements(const Vector& z) const {
  std::string complaint = coordinates_.apply(z, graph_.data());
  if (!complaint.empty()) return complaint;
  z_ = z;
  point_ = std::make_unique<pgo::GraphPoint>(graph_.data(), graph_.options());
  return complaint;
}

bool SlamLowerProblem::factorize() {
  factor_.compute(point_->gauss_newton_hessian());
  factored_ = factor_.info() == Eigen::Success;
  return factored_;
}

/// Gauss-Newton steps with the one factor: each costs a gradient only, a tenth of a solver's step.
double SlamLowerProblem::descend() {
  Vector slope = cost_by_phi();
  double least = slope.lpNorm<Eigen::Infinity>();
  for (int i = 0; i < kDescents && least > kAim; ++i) {
    const Vector before = point_->numbers();
    point_->move(tau_of(-slope));
    slope = cost_by_phi();
    const double norm = slope.lpNorm<Eigen::Infinity>();
    if (!(norm < kGain * least)) {
      point_->set_numbers(before);
      break;
    }
    least = norm;
  }
  return least;
}

SlamLowerProblem::Vector SlamLowerProblem::tau_of(const Vector& y) const {
  expects(factored_, "slam lower problem: asked before it was solved");
  const Vector permuted = factor_.matrixU().solve(y);
  return factor_.permutationPinv() * permuted;
}

SlamLowerProblem::Vector SlamLowerProblem::by_phi_of(const Vector& by_tau) const {
  expects(factored_, "slam lower problem: asked before it was solved");
  const Vector permuted = factor_.permutationP() * by_tau;
  return factor_.matrixL().solve(permuted);
}

SlamLowerProblem::Vector SlamLowerProblem::by_tau_of(const Vector& by_phi) const {
  const Vector permuted = factor_.matrixL() * by_phi;
  return factor_.permutationPinv() * permuted;
}

double SlamLowerProblem::cost() const { return pgo::negative_log_likelihood(graph_).total(); }

SlamLowerProblem::Vector SlamLowerProblem::cost_by_z() const {
  return coordinates_.pull_back(z_, pgo::measurement_gradient(graph_, true));
}

SlamLowerProblem::Vector SlamLowerProblem::cost_by_phi() const {
  return by_phi_of(point_->gradient());
}

learner::UpperValue SlamLowerProblem::upper_cost() const {
  learner::UpperValue upper = slam_upper_cost(upper_options_, graph_, *point_, coordinates_, z_);
  upper.by_phi = by_phi_of(upper.by_phi);
  return upper;
}

/// d/dh f(mu Exp(h tau(y))) at h = 0.
SlamLowerProblem::Vector SlamLowerProblem::derivative(const Vector& y,
                                                      const std::function<Vector()>& f) const {
  const Vector tau = tau_of(y);
  const double step =
      1.0 / std::max(y.norm() / kStep, tau.lpNorm<Eigen::Infinity>() / kTangentStep);
  const Vector start = point_->numbers();
  const auto at = [&](double h) -> Vector {
    point_->set_numbers(start);
    point_->move(h * tau);
    return f();
  };
  if (!std::isfinite(step)) return Vector::Zero(f().size());  // y = 0
  Vector slope = 8.0 * (at(step) - at(-step)) - (at(2.0 * step) - at(-2.0 * step));
  point_->set_numbers(start);
  return slope / (12.0 * step);
}

SlamLowerProblem::Vector SlamLowerProblem::hessian_product(const Vector& v) const {
  return derivative(v, [this] { return cost_by_phi(); });
}

SlamLowerProblem::Vector SlamLowerProblem::mixed_product(const Vector& v) const {
  pgo::PoseVelocityGraph moved = graph_;
  return derivative(v, [&]() -> Vector {
    point_->store(moved.data());
    return coordinates_.pull_back(z_, pgo::measurement_gradient(moved));
  });
}

std::optional<learner::Vector> SlamLowerProblem::hessian_solve(const Vector& v) const {
  if (!factored_) return std::nullopt;
  const auto H = [this](const Vector& x) { return hessian_product(x); };
  learner::LinearSolution solution =
      learner::conjugate_gradient(H, v, {kLinearAim, kLinearIterations, 0.0});
  if (!(solution.report.residual <= kLinearTolerance)) return std::nullopt;
  return std::move(solution.q);
}

}  // namespace imslam::system
