#include "vo_net/pose_layer.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>

#include "slam/base/error.hpp"
#include "vo_net/pose_layer_covariance.hpp"
#include "vo_net/pose_layer_system.hpp"

namespace imslam::vo {
namespace {

using detail::Estimate;
using detail::Model;
using detail::Problem;
using detail::ReducedSystem;
using detail::ReducedVector;
using detail::solve_positive;
using detail::Spread;
using Matrix6 = Eigen::Matrix<double, 6, 6>;
using Vector6 = Eigen::Matrix<double, 6, 1>;

constexpr double kMedianChiSquared3 = 2.366;  // of s, which has 4 - 1 degrees of freedom
constexpr double kStartDamping = 1e-6;
constexpr int kNarrowings = 4;         // rounds of the final descent
constexpr double kMuchNarrower = 0.7;  // the scale must fall below this share to repeat it

double median(std::vector<double>& values) {
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end());
  return *middle;
}

class Solver {
 public:
  Solver(Problem problem, const PoseLayerOptions& options, Estimate start)
      : problem_(std::move(problem)), options_(options), estimate_(std::move(start)) {}

  /// Follows the minimum while the kernel narrows with the median residual.
  bool start();
  /// Levenberg-Marquardt at a fixed kernel; again with a narrower one if the start stopped too
  /// soon. False if the points do not agree on a motion.
  bool refine();

  const Problem& problem() const { return problem_; }
  const Estimate& estimate() const { return estimate_; }
  double noise_scale() const { return noise_scale_; }
  bool converged() const { return converged_; }
  int iterations() const { return iterations_; }

 private:
  void descend();
  double measured_noise_scale(const ReducedSystem& system) const;
  void set_kernel(double scale) { problem_.kernel_k2 = std::pow(options_.kernel_width * scale, 2); }
  std::optional<Estimate> moved(const ReducedSystem& system, double* decrement);
  Model model_after(double decrement) const {
    return decrement < 1.0 ? Model::kExact : Model::kGaussNewton;
  }

  Problem problem_;
  const PoseLayerOptions& options_;
  Estimate estimate_;
  ReducedSystem system_;
  ReducedSystem candidate_system_;
  double noise_scale_ = 1.0;
  bool converged_ = false;
  int iterations_ = 0;
};

double Solver::measured_noise_scale(const ReducedSystem& system) const {
  std::vector<double> s;
  for (std::size_t k = 0; k < system.points.size(); ++k) {
    if (problem_.usable[k] != 0) s.push_back(system.points[k].s);
  }
  return s.empty() ? 1.0 : std::sqrt(median(s) / kMedianChiSquared3);
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
  for (int i = 0; i < options_.start_iterations; ++i, ++iterations_) {
    set_kernel(std::isfinite(scale) ? scale : options_.max_noise_scale);
    detail::build_system(problem_, estimate_, Model::kGaussNewton, kStartDamping, system_);
    const double measured = std::max(options_.min_noise_scale, measured_noise_scale(system_));
    const bool settled = std::abs(measured - scale) < 0.02 * scale;
    scale = measured;
    if (settled) break;
    if (i == 0) {
      set_kernel(scale);
      detail::build_system(problem_, estimate_, Model::kGaussNewton, kStartDamping, system_);
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
  detail::build_system(problem_, estimate_, model, damping, system_);
  for (int i = 0; i < options_.max_iterations; ++i, ++iterations_) {
    double next_decrement = 0.0;
    std::optional<Estimate> next = moved(system_, &next_decrement);
    double next_cost = std::numeric_limits<double>::infinity();
    const Model next_model = model_after(next_decrement);
    const double next_damping = next_model == Model::kExact ? 0.0 : damping * 0.1;
    if (next) {
      detail::build_system(problem_, *next, next_model, next_damping, candidate_system_);
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
    detail::build_system(problem_, estimate_, model, damping, system_);
  }
}

void fill_calibration(const ReducedSystem& exact, double factor, PoseLayerResult& result) {
  const Matrix6 H = exact.H.topLeftCorner<6, 6>();
  const Vector6 coupling = exact.H.block<6, 1>(0, 6);
  const std::optional<Vector6> J = solve_positive(H, -coupling);
  if (!J) return;
  result.J_disparity_offset = *J;
  result.offset_gradient = (exact.g[6] + J->dot(exact.g.head<6>())) / factor;
  result.offset_information = std::max(0.0, exact.H(6, 6) + J->dot(coupling)) / factor;
  const std::optional<Vector6> J_focal = solve_positive(H, -exact.H.block<6, 1>(0, 7));
  if (J_focal) result.J_focal_error = *J_focal;
}

void fill_inliers(const Solver& solver,
                  const ReducedSystem& system,
                  const PoseLayerOptions& options,
                  PoseLayerResult& result) {
  const double limit = std::pow(options.inlier_threshold * solver.noise_scale(), 2);
  result.is_inlier.assign(system.points.size(), 0);
  for (std::size_t k = 0; k < system.points.size(); ++k) {
    const bool inlier = system.points[k].curvature > 0.0 && system.points[k].s < limit;
    result.is_inlier[k] = inlier ? 1 : 0;
    result.inliers += inlier ? 1 : 0;
  }
}

bool certain_enough(const Matrix6& covariance, const PoseLayerOptions& options) {
  const Vector6 variances = covariance.diagonal();
  return variances.allFinite() &&
         variances.head<3>().maxCoeff() < std::pow(options.max_sigma_translation, 2) &&
         variances.tail<3>().maxCoeff() < std::pow(options.max_sigma_rotation, 2);
}

void to_body(const StereoCamera& camera, const Estimate& estimate, PoseLayerResult& result) {
  const lie::SE3d& T_body_left = camera.T_body_left;
  result.T_body0_body1 = T_body_left * estimate.T_left0_left1 * T_body_left.inverse();
  const Matrix6 A = T_body_left.adjoint();
  const Matrix6 covariance = A * result.covariance * A.transpose();
  result.covariance = 0.5 * (covariance + covariance.transpose());
  result.J_disparity_offset = A * result.J_disparity_offset;
  result.J_focal_error = A * result.J_focal_error;
}

}  // namespace

PoseLayerResult solve_pose(const Correspondences& correspondences,
                           const StereoCamera& camera,
                           const PoseLayerOptions& options,
                           const lie::SE3d& T_body0_body1_start,
                           double disparity_offset) {
  PoseLayerResult result;
  result.disparity_offset = disparity_offset;
  result.is_inlier.assign(correspondences.size(), 0);

  const lie::SE3d& T_body_left = camera.T_body_left;
  Estimate start{T_body_left.inverse() * T_body0_body1_start * T_body_left, {}};
  for (const Correspondence& c : correspondences) {
    start.disparities.push_back(c.disparity0 - disparity_offset);
  }
  result.disparities = start.disparities;
  Problem problem = detail::make_problem(correspondences, camera, options, 1.0, disparity_offset);
  const auto usable = std::count(problem.usable.begin(), problem.usable.end(), 1);
  if (usable < std::max(options.min_inliers, 3)) return result;

  Solver solver(std::move(problem), options, std::move(start));
  if (!solver.start()) return result;
  if (!solver.refine()) return result;
  result.converged = solver.converged();
  result.iterations = solver.iterations();
  result.noise_scale = solver.noise_scale();

  ReducedSystem system;
  detail::build_system(solver.problem(), solver.estimate(), Model::kGaussNewton, 0.0, system);
  fill_inliers(solver, system, options, result);
  const std::optional<Spread> spread = detail::spread_of(solver.problem(), system);
  if (!spread || result.inliers < options.min_inliers || !result.converged) return result;
  result.cost = system.cost;
  result.covariance = spread->covariance;
  result.disparities = solver.estimate().disparities;
  detail::build_system(solver.problem(), solver.estimate(), Model::kExact, 0.0, system,
                       detail::Unknowns::kMotionAndCalibration);
  fill_calibration(system, spread->factor, result);
  to_body(camera, solver.estimate(), result);
  result.valid =
      certain_enough(result.covariance, options) && result.T_body0_body1.translation().allFinite();
  return result;
}

}  // namespace imslam::vo
