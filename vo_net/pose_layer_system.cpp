#include "vo_net/pose_layer_system.hpp"

#include <cmath>

namespace imslam::vo::detail {
namespace {

/// What a point costs that would lie behind the camera: more than any sane residual.
constexpr double kBehindCamera = 1e6;

bool is_usable(const Correspondence& c) {
  const Eigen::Matrix2d& F = c.flow_information;
  const bool finite = c.left0.allFinite() && c.left1.allFinite() && F.allFinite() &&
                      std::isfinite(c.disparity0) && std::isfinite(c.disparity1) &&
                      std::isfinite(c.disparity0_information) &&
                      std::isfinite(c.disparity1_information) && std::isfinite(c.weight);
  return finite && c.weight > 0.0 && c.disparity0_information > 0.0 &&
         c.disparity1_information >= 0.0 && F(0, 0) >= 0.0 && F(1, 1) >= 0.0 &&
         F.determinant() >= 0.0;
}

ReducedVector without_disparity(const PointVector& v) {
  ReducedVector r;
  r << v.head<6>(), v.tail<2>();
  return r;
}

void add_reduced_motion(const PointModel& m, double curvature, ReducedSystem& system) {
  const Eigen::Matrix<double, 6, 1> coupling = m.H.block<6, 1>(0, kDisparity);
  system.H.topLeftCorner<6, 6>() +=
      m.H.topLeftCorner<6, 6>() - coupling * (coupling / curvature).transpose();
  system.g.head<6>() += m.g.head<6>() - coupling * (m.g[kDisparity] / curvature);
}

void add_reduced(const PointModel& m, double curvature, ReducedSystem& system) {
  const ReducedVector coupling = without_disparity(m.H.col(kDisparity));
  system.H.topLeftCorner<6, 6>() += m.H.topLeftCorner<6, 6>();
  system.H.topRightCorner<6, 2>() += m.H.topRightCorner<6, 2>();
  system.H.bottomLeftCorner<2, 6>() += m.H.bottomLeftCorner<2, 6>();
  system.H.bottomRightCorner<2, 2>() += m.H.bottomRightCorner<2, 2>();
  system.H -= coupling * (coupling / curvature).transpose();
  system.g += without_disparity(m.g) - coupling * (m.g[kDisparity] / curvature);
}

/// Fills the first kColumns rows and columns of m; f = Omega e.
template <int kColumns>
void add_quadratic(const Views& views,
                   const Correspondence& c,
                   const PointState& point,
                   const Eigen::Vector4d& f,
                   Model model,
                   PointModel& m) {
  using Jacobian = Eigen::Matrix<double, 4, kColumns>;
  const Jacobian J = point_jacobian<kColumns>(views, point);
  const Eigen::Matrix<double, kColumns, 1> Jf = J.transpose() * f;
  Jacobian OmegaJ;
  OmegaJ.template topRows<2>() = c.flow_information * J.template topRows<2>();
  OmegaJ.row(2) = c.disparity0_information * J.row(2);
  OmegaJ.row(3) = c.disparity1_information * J.row(3);
  const double weight = c.weight * m.kernel.first;
  m.g.template head<kColumns>() = weight * Jf;
  Eigen::Ref<Eigen::Matrix<double, kColumns, kColumns>, 0, Eigen::OuterStride<>> H =
      m.H.template topLeftCorner<kColumns, kColumns>();
  H = weight * J.transpose().lazyProduct(OmegaJ);  // Eigen would take its big-matrix way
  if (model == Model::kExact) {
    H += weight * curvature<kColumns>(views, point, f);
    H += (2.0 * c.weight * m.kernel.second) * (Jf * Jf.transpose());
  }
}

}  // namespace

void ReducedSystem::back_substitute(const ReducedVector& step, std::vector<double>& d) const {
  for (std::size_t k = 0; k < points.size(); ++k) {
    const EliminatedPoint& p = points[k];
    if (p.curvature <= 0.0) continue;
    d[k] -= (p.gradient + p.coupling.dot(step)) / (p.curvature * (1.0 + damping));
  }
}

Problem make_problem(const Correspondences& correspondences,
                     const StereoCamera& camera,
                     const PoseLayerOptions& options,
                     double noise_scale,
                     double offset) {
  const double width = options.kernel_width * noise_scale;
  Problem problem{correspondences, camera, options.robust_kernel(), width * width, offset, {}};
  problem.usable.reserve(correspondences.size());
  for (const Correspondence& c : correspondences) problem.usable.push_back(is_usable(c) ? 1 : 0);
  return problem;
}

PointModel model_point(const Problem& problem,
                       const Views& views,
                       const Correspondence& c,
                       const PointState& point,
                       Model model,
                       Unknowns unknowns) {
  PointModel m;
  m.H.setZero();
  m.g.setZero();
  const Eigen::Vector4d f = apply_information(c, point.e);
  m.s = point.e.dot(f);
  m.kernel = evaluate_kernel(problem.kernel, m.s, problem.kernel_k2);
  m.cost = 0.5 * c.weight * m.kernel.rho;
  if (unknowns == Unknowns::kMotion) {
    add_quadratic<kMotionUnknowns>(views, c, point, f, model, m);
  } else {
    add_quadratic<kUnknowns>(views, c, point, f, model, m);
  }
  return m;
}

void build_system(const Problem& problem,
                  const Estimate& estimate,
                  Model model,
                  double damping,
                  ReducedSystem& system,
                  Unknowns unknowns) {
  const Views views(problem.camera, estimate.T_left0_left1, problem.offset);
  const std::size_t count = problem.correspondences.size();
  system.H.setZero();
  system.g.setZero();
  system.cost = 0.0;
  system.damping = damping;
  system.used = 0;
  system.points.assign(count, EliminatedPoint());
  for (std::size_t k = 0; k < count; ++k) {
    if (problem.usable[k] == 0) continue;
    const Correspondence& c = problem.correspondences[k];
    const PointState point = evaluate_point(views, c, estimate.disparities[k]);
    EliminatedPoint& eliminated = system.points[k];
    if (!point.in_front) {
      eliminated.s = kBehindCamera;
      system.cost +=
          0.5 * c.weight * evaluate_kernel(problem.kernel, kBehindCamera, problem.kernel_k2).rho;
      continue;
    }
    PointModel m = model_point(problem, views, c, point, model, unknowns);
    if (model == Model::kExact && !(m.H(kDisparity, kDisparity) > 0.0)) {
      m = model_point(problem, views, c, point, Model::kGaussNewton, unknowns);
    }
    eliminated.s = m.s;
    eliminated.slope = m.kernel.first;
    eliminated.bend = m.kernel.second;
    system.cost += m.cost;
    ++system.used;
    const double own_curvature = m.H(kDisparity, kDisparity);
    if (!(own_curvature > 0.0)) continue;
    eliminated.coupling = without_disparity(m.H.col(kDisparity));
    eliminated.curvature = own_curvature;
    eliminated.gradient = m.g[kDisparity];
    const double damped = own_curvature * (1.0 + damping);
    if (unknowns == Unknowns::kMotion) {
      add_reduced_motion(m, damped, system);
    } else {
      add_reduced(m, damped, system);
    }
  }
}

}  // namespace imslam::vo::detail
