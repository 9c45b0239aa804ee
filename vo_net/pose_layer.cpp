#include "vo_net/pose_layer.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>

#include "slam/base/error.hpp"
#include "vo_net/pose_consensus.hpp"
#include "vo_net/pose_layer_covariance.hpp"
#include "vo_net/pose_layer_system.hpp"
#include "vo_net/pose_solver.hpp"

namespace imslam::vo {
namespace {

using detail::Estimate;
using detail::Model;
using detail::Problem;
using detail::ReducedSystem;
using detail::ReducedVector;
using detail::solve_positive;
using detail::Solver;
using detail::Spread;
using Matrix6 = Eigen::Matrix<double, 6, 6>;
using Vector6 = Eigen::Matrix<double, 6, 1>;

constexpr double kLeastConsensus = 0.3;       // of the points: fewer may agree by chance
constexpr double kConsensusNoiseScale = 2.0;  // informations are off by that much at most, there
constexpr double kLeastForetold = 0.15;       // where the motion is foretold chance does less
constexpr double kLeastBeside = 0.5;  // share of the largest group's, where that turns as foretold
constexpr double kVisionSigma_rad = 1e-3;  // what vision may be off by itself

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

/// Body to left camera; a lever arm that turns by sigma_rad moves, too.
detail::Foretold to_camera(const StereoCamera& camera, const ForetoldMotion& foretold) {
  const lie::SE3d& T_body_left = camera.T_body_left;
  const lie::SE3d T_body0_body1(foretold.R_body0_body1,
                                foretold.p_body0_body1.value_or(Eigen::Vector3d::Zero()));
  detail::Foretold result;
  result.T_left0_left1 = T_body_left.inverse() * T_body0_body1 * T_body_left;
  result.sigma_rad = std::hypot(foretold.sigma_rad, kVisionSigma_rad);
  result.translation_known = foretold.p_body0_body1.has_value();
  result.sigma_m = foretold.sigma_m + result.sigma_rad * T_body_left.translation().norm();
  return result;
}

/// Covariance, inliers and derivatives where the solver stopped.
PoseLayerResult finish(const Solver& solver,
                       const StereoCamera& camera,
                       const PoseLayerOptions& options,
                       PoseLayerResult result) {
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

/// A minimum and the share of the points that agree on it.
struct Attempt {
  Solver solver;
  double share = 0.0;
};

/// The minimum near a motion that many points agree on, or none.
std::optional<Attempt> solve_near(const std::optional<detail::Consensus>& consensus,
                                  const Problem& problem,
                                  const PoseLayerOptions& options,
                                  double least_share,
                                  double limit) {
  if (!consensus || !(consensus->share > least_share)) return std::nullopt;
  Attempt attempt{Solver(problem, options, consensus->estimate, std::min(1.0, consensus->share)),
                  0.0};
  if (!attempt.solver.solve()) return std::nullopt;
  attempt.share = attempt.solver.share_below(limit);
  return attempt;
}

/// The group of points that moves as the scene does, in place of `best`, if there is reason to look
/// for one.
std::optional<Attempt> best_group(std::optional<Attempt> best,
                                  const Problem& problem,
                                  const PoseLayerOptions& options,
                                  const Estimate& start,
                                  const std::optional<detail::Foretold>& foretold) {
  const double limit = std::pow(kConsensusNoiseScale * options.inlier_threshold, 2);
  if (options.consensus_share <= 0.0) return best;
  const bool few = !best || best->share < options.consensus_share;
  if (few) {
    auto largest = solve_near(detail::find_consensus(problem, start, limit), problem, options,
                              kLeastConsensus, limit);
    if (largest && (!best || largest->share > best->share)) best.emplace(std::move(*largest));
  }
  if (!foretold) return best;
  const auto turns = [&](const Attempt& a) {
    return foretold->turns_alike(a.solver.estimate().T_left0_left1);
  };
  const auto moves = [&](const Attempt& a) {
    return foretold->moves_alike(a.solver.estimate().T_left0_left1);
  };
  if (!few && turns(*best) && moves(*best)) return best;
  auto alike = solve_near(detail::find_foretold(problem, start, *foretold), problem, options,
                          kLeastForetold, limit);
  if (!alike || alike->share < kLeastForetold || !turns(*alike) || !moves(*alike)) return best;
  // Of what was foretold the translation is the less certain: it leans on vision's past.
  const bool better = !best || alike->share > best->share || !turns(*best) ||
                      (!moves(*best) && alike->share > kLeastBeside * best->share);
  return better ? std::move(alike) : std::move(best);
}

}  // namespace

PoseLayerResult solve_pose(const Correspondences& correspondences,
                           const StereoCamera& camera,
                           const PoseLayerOptions& options,
                           const lie::SE3d& T_body0_body1_start,
                           double disparity_offset,
                           const std::optional<ForetoldMotion>& foretold) {
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

  std::optional<Attempt> best(Attempt{Solver(problem, options, start, 1.0), 0.0});
  if (best->solver.solve()) {
    best->share =
        best->solver.share_below(std::pow(kConsensusNoiseScale * options.inlier_threshold, 2));
  } else {
    best.reset();
  }
  std::optional<detail::Foretold> in_camera;
  if (foretold) in_camera = to_camera(camera, *foretold);
  const auto group = best_group(std::move(best), problem, options, start, in_camera);
  if (!group) return result;
  return finish(group->solver, camera, options, std::move(result));
}

}  // namespace imslam::vo
