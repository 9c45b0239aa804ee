#include "vo_net/pose_solver.hpp"

#include <algorithm>
#include <limits>
#include <vector>

#include "vo_net/pose_layer_covariance.hpp"

namespace imslam::vo::detail {
namespace {

using Matrix6 = Eigen::Matrix<double, 6, 6>;
using Vector6 = Eigen::Matrix<double, 6, 1>;

constexpr double kMedianChiSquared3 = 2.366;  // of s, which has 4 - 1 degrees of freedom
constexpr double kStartDamping = 1e-6;
constexpr int kNarrowings = 4;         // rounds of the final descent
constexpr double kMuchNarrower = 0.7;  // the scale must fall below this share to repeat it

/// The median of the smallest `share` of the values.
double median(std::vector<double>& values, double share) {
  const double rank = 0.5 * share * static_cast<double>(values.size());
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(rank);
  std::nth_element(values.begin(), middle, values.end());
  return *middle;
}

}  // namespace

double Solver::measured_noise_scale(const ReducedSystem& system) const {
  std::vector<double> s;
  for (std::size_t k = 0; k < system.points.size(); ++k) {
    if (problem_.usable[k] != 0) s.push_back(system.points[k].s);
  }
  return s.empty() ? 1.0 : std::sqrt(median(s, agreeing_) / kMedianChiSquared3);
}

double Solver::share_below(double limit) {
  build_system(problem_, estimate_, Model::kGaussNewton, 0.0, system_);
  double below = 0.0;
  double usable = 0.0;
  for (std::size_t k = 0; k < system_.points.size(); ++k) {
    if (problem_.usable[k] == 0) continue;
    usable += 1.0;
    if (system_.points[k].curvature > 0.0 && system_.points[k].s < limit) below += 1.0;
  }
  return usable > 0.0 ? below / usable : 0.0;
}

/// The estimate one damped step further; `decrement` is the step in standard deviations of the
/// pose.
std::optional<Estimate> Solver::moved(const ReducedSystem& system, double* decrement) {
  Matrix6 H = system.H.topLeftCorner<6, 6>();
  H.diagonal() *= 1.0 + system.damping;
  const std::optional<Vector6> step = solve_positive(H, -system.g.head<6>());
  if (!step) return std::nullopt;
  *decrement = std::sqrt(std::max(0.0, -step->dot(system.g.head<6>())));
  Estimate next = estimate_;
  next.T_left0_left1 = estimate_.T_left0_left1 * lie::SE3d::exp(*step);
  ReducedVector reduced_step;
  reduced_step << *step, 0.0, 0.0;
  system.back_substitute(reduced_step, next.disparities);
  return next;
}

bool Solver::start() {
  double scale = std::numeric_limits<double>::infinity();
  if (agreeing_ < 1.0) {
    set_kernel(options_.max_noise_scale);
    build_system(problem_, estimate_, Model::kGaussNewton, kStartDamping, system_);
    scale = std::max(options_.min_noise_scale, measured_noise_scale(system_));
  }
  for (int i = 0; i < options_.start_iterations; ++i, ++iterations_) {
    set_kernel(std::isfinite(scale) ? scale : options_.max_noise_scale);
    build_system(problem_, estimate_, Model::kGaussNewton, kStartDamping, system_);
    const double measured = std::max(options_.min_noise_scale, measured_noise_scale(system_));
    const bool settled = std::abs(measured - scale) < 0.02 * scale;
    scale = measured;
    if (settled) break;
    if (i == 0) {
      set_kernel(scale);
      build_system(problem_, estimate_, Model::kGaussNewton, kStartDamping, system_);
    }
    double decrement = 0.0;
    const std::optional<Estimate> next = moved(system_, &decrement);
    if (!next) return false;
    estimate_ = *next;
  }
  scale = std::clamp(scale, options_.min_noise_scale, options_.max_noise_scale);
  noise_scale_ = options_.adapt_noise_scale ? scale : 1.0;
  set_kernel(noise_scale_);
  return true;
}

bool Solver::refine() {
  for (int round = 0; round < kNarrowings; ++round) {
    descend();
    if (!options_.adapt_noise_scale) return true;
    const double measured = measured_noise_scale(system_);
    const double narrower = std::max(measured, options_.min_noise_scale);
    if (!(narrower < kMuchNarrower * noise_scale_)) return measured <= options_.max_noise_scale;
    noise_scale_ = narrower;
    set_kernel(noise_scale_);
  }
  return true;
}

void Solver::descend() {
  converged_ = false;
  double damping = kStartDamping;
  double decrement = std::numeric_limits<double>::infinity();
  Model model = Model::kGaussNewton;
  build_system(problem_, estimate_, model, damping, system_);
  for (int i = 0; i < options_.max_iterations; ++i, ++iterations_) {
    double next_decrement = 0.0;
    std::optional<Estimate> next = moved(system_, &next_decrement);
    double next_cost = std::numeric_limits<double>::infinity();
    const Model next_model = model_after(next_decrement);
    const double next_damping = next_model == Model::kExact ? 0.0 : damping * 0.1;
    if (next) {
      build_system(problem_, *next, next_model, next_damping, candidate_system_);
      next_cost = candidate_system_.cost;
    }
    // At the bottom the cost is flat to the last digits: rounding must not count as an increase.
    const double slack = 1e-12 * (1.0 + system_.cost);
    if (next && next_cost <= system_.cost + slack) {
      estimate_ = std::move(*next);
      std::swap(system_, candidate_system_);
      decrement = next_decrement;
      model = next_model;
      damping = next_damping;
      if (decrement < options_.tolerance) {
        converged_ = true;
        return;
      }
      continue;
    }
    damping = std::max(1e-4, damping * 10.0);
    if (damping > 1e8) return;
    model = Model::kGaussNewton;
    build_system(problem_, estimate_, model, damping, system_);
  }
}

}  // namespace imslam::vo::detail
