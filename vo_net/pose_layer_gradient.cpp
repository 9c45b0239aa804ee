#include "vo_net/pose_layer_gradient.hpp"

#include <Eigen/Cholesky>
#include <cmath>

#include "slam/base/error.hpp"
#include "vo_net/pose_layer_system.hpp"

namespace imslam::vo {
namespace {

using detail::PointVector;
using Vector6 = Eigen::Matrix<double, 6, 1>;
using Matrix6 = Eigen::Matrix<double, 6, 6>;

/// Farther from the minimum than this the derivative would be wrong [standard deviations].
constexpr double kMaxDecrement = 1e-4;

/// Change of one point's cost gradient along q, differentiated by what the point was given:
///
///   D(z) = q . d/dx [1/2 w rho(e^T Omega e)] = w rho'(s) m,   m = (J q)^T Omega e
CorrespondenceGradient pull_back_point(const detail::Views& views,
                                       const Correspondence& c,
                                       const detail::PointState& point,
                                       const detail::PointModel& model,
                                       const PointVector& q) {
  const Eigen::Vector4d a = detail::point_jacobian(views, point) * q;
  const Eigen::Vector4d f = detail::apply_information(c, point.e);
  const double m = a.dot(f);
  const double first = c.weight * model.kernel.first;
  const double second = c.weight * model.kernel.second;
  const Eigen::Vector4d D_e = first * detail::apply_information(c, a) + (2.0 * second * m) * f;

  CorrespondenceGradient gradient;  // dL/dz = -dD/dz; e falls as the measurements rise
  gradient.left1 = D_e.head<2>();
  gradient.disparity0 = D_e[2];
  gradient.disparity1 = D_e[3];
  gradient.left0 = -(detail::left0_jacobian(views, point).transpose() * D_e +
                     first * (detail::left0_mixed_derivative(views, point, q).transpose() * f));
  const Eigen::Vector2d a_flow = a.head<2>();
  const Eigen::Vector2d e_flow = point.e.head<2>();
  gradient.flow_information =
      -(0.5 * first) * (a_flow * e_flow.transpose() + e_flow * a_flow.transpose()) -
      (second * m) * (e_flow * e_flow.transpose());
  gradient.disparity0_information =
      -(first * a[2] * point.e[2] + second * m * point.e[2] * point.e[2]);
  gradient.disparity1_information =
      -(first * a[3] * point.e[3] + second * m * point.e[3] * point.e[3]);
  gradient.weight = -model.kernel.first * m;
  return gradient;
}

/// dL/d(tangent of the left camera's motion), from that of the body's.
Vector6 to_left(const StereoCamera& camera, const Vector6& dL_dpose_body) {
  return camera.T_body_left.adjoint().transpose() * dL_dpose_body;
}

bool is_stationary(const Eigen::LLT<Matrix6>& factor, const detail::ReducedSystem& system) {
  const Vector6 g = system.g.head<6>();
  return std::sqrt(std::max(0.0, g.dot(factor.solve(g)))) < kMaxDecrement;
}

}  // namespace

std::optional<PoseLayerGradient> pose_layer_gradient(const Correspondences& correspondences,
                                                     const StereoCamera& camera,
                                                     const PoseLayerOptions& options,
                                                     const PoseLayerResult& result,
                                                     const Vector6& dL_dpose) {
  expects(result.disparities.size() == correspondences.size(),
          "pose_layer_gradient: result does not belong to these correspondences");
  if (!result.valid) return std::nullopt;
  const lie::SE3d& T_body_left = camera.T_body_left;
  const detail::Estimate estimate{T_body_left.inverse() * result.T_body0_body1 * T_body_left,
                                  result.disparities};
  const detail::Problem problem = detail::make_problem(correspondences, camera, options,
                                                       result.noise_scale, result.disparity_offset);
  detail::ReducedSystem system;
  detail::build_system(problem, estimate, detail::Model::kExact, 0.0, system);
  const Eigen::LLT<Matrix6> factor(system.H.topLeftCorner<6, 6>());
  if (factor.info() != Eigen::Success || !is_stationary(factor, system)) return std::nullopt;
  const Vector6 q_pose = factor.solve(to_left(camera, dL_dpose));
  if (!q_pose.allFinite()) return std::nullopt;

  PoseLayerGradient gradient;
  gradient.correspondences.resize(correspondences.size());
  gradient.disparity_offset = dL_dpose.dot(result.J_disparity_offset);
  const detail::Views views(camera, estimate.T_left0_left1, result.disparity_offset);
  for (std::size_t k = 0; k < correspondences.size(); ++k) {
    const detail::EliminatedPoint& eliminated = system.points[k];
    if (eliminated.curvature <= 0.0) continue;
    const detail::PointState point =
        detail::evaluate_point(views, correspondences[k], estimate.disparities[k]);
    const detail::PointModel model =
        detail::model_point(problem, views, correspondences[k], point, detail::Model::kGaussNewton);
    PointVector q;
    q << q_pose, -eliminated.coupling.head<6>().dot(q_pose) / eliminated.curvature, 0.0, 0.0;
    gradient.correspondences[k] = pull_back_point(views, correspondences[k], point, model, q);
  }
  return gradient;
}

}  // namespace imslam::vo
