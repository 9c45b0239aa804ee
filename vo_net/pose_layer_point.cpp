#include "vo_net/pose_layer_point.hpp"

namespace imslam::vo::detail {
namespace {

/// Nearer to the image plane than this, relative to the depth in left0, a point cannot be seen.
constexpr double kMinDepthRatio = 1e-3;

/// Of [u v disparity1] to [Y disparity focal].
using ProjectionJacobian = Eigen::Matrix<double, 3, 5>;
using Matrix5 = Eigen::Matrix<double, 5, 5>;

ProjectionJacobian projection_jacobian(const Views& views, const PointState& p) {
  const double iz = 1.0 / p.Y.z();
  const double x = p.Y.x() * iz;
  const double y = p.Y.y() * iz;
  ProjectionJacobian P;
  P << views.camera.fx * iz, 0.0, -views.camera.fx * x * iz, 0.0, views.camera.fx * x,  //
      0.0, views.camera.fy * iz, -views.camera.fy * y * iz, 0.0, views.camera.fy * y,   //
      0.0, 0.0, -p.disparity * iz * iz, iz, 0.0;
  return P;
}

/// Second derivative of sum_r f_r [u v disparity1]_r with respect to [Y disparity focal].
Matrix5 projection_curvature(const Views& views, const PointState& p, const Eigen::Vector3d& f) {
  const double iz = 1.0 / p.Y.z();
  const double iz2 = iz * iz;
  const double a = f[0] * views.camera.fx;
  const double b = f[1] * views.camera.fy;
  Matrix5 C = Matrix5::Zero();
  C(0, 2) = C(2, 0) = -a * iz2;
  C(1, 2) = C(2, 1) = -b * iz2;
  C(3, 2) = C(2, 3) = -f[2] * iz2;
  C(2, 2) = 2.0 * iz2 * iz * (a * p.Y.x() + b * p.Y.y() + f[2] * p.disparity);
  C(0, 4) = C(4, 0) = a * iz;
  C(1, 4) = C(4, 1) = b * iz;
  C(2, 4) = C(4, 2) = -iz2 * (a * p.Y.x() + b * p.Y.y());
  return C;
}

/// d[Y disparity focal]/d(unknowns); the pose moves as T_left0_left1 Exp(tau), so p_left1 as
/// Exp(-tau). Without the calibration the last row is left out too.
template <int kColumns>
using ScaledJacobian = Eigen::Matrix<double, kColumns == kUnknowns ? 5 : 4, kColumns>;

template <int kColumns>
ScaledJacobian<kColumns> scaled_point_jacobian(const Views& views, const PointState& p) {
  ScaledJacobian<kColumns> J = ScaledJacobian<kColumns>::Zero();
  J.template topLeftCorner<3, 3>().diagonal().setConstant(-p.disparity *
                                                          views.inverse_focal_baseline);
  J.template block<3, 3>(0, 3) = lie::skew(p.Y);
  J.template block<3, 1>(0, kDisparity) = views.Y_disparity;
  J(3, kDisparity) = 1.0;
  if constexpr (kColumns == kUnknowns) {
    J.template block<3, 1>(0, kFocal) = p.Y_focal;
    J(4, kFocal) = 1.0;
  }
  return J;
}

/// dY/d(left0) (3x2).
Eigen::Matrix<double, 3, 2> scaled_point_left0_jacobian(const Views& views) {
  Eigen::Matrix<double, 3, 2> J;
  J << views.R_left1_left0.col(0) / views.camera.fx, views.R_left1_left0.col(1) / views.camera.fy;
  return J;
}

/// Puts the rows [u v disparity1] of `rows` at their places in e; the row of disparity0 stays 0.
template <int kColumns>
Eigen::Matrix<double, 4, kColumns> spread_rows(const Eigen::Matrix<double, 3, kColumns>& rows) {
  Eigen::Matrix<double, 4, kColumns> result = Eigen::Matrix<double, 4, kColumns>::Zero();
  result.template topRows<2>() = rows.template topRows<2>();
  result.row(3) = rows.row(2);
  return result;
}

}  // namespace

PointState evaluate_point(const Views& views, const Correspondence& c, double disparity) {
  const StereoCamera& camera = views.camera;
  const Eigen::Vector3d ray((c.left0.x() - camera.cx) / camera.fx,
                            (c.left0.y() - camera.cy) / camera.fy, 1.0);
  PointState p;
  p.disparity = disparity;
  p.Y = views.R_left1_left0 * ray + disparity * views.Y_disparity;
  p.Y_focal = -(views.R_left1_left0.leftCols<2>() * ray.head<2>());
  p.in_front = p.Y.z() > kMinDepthRatio;
  if (!p.in_front) return p;
  const double iz = 1.0 / p.Y.z();
  p.e << camera.fx * p.Y.x() * iz + camera.cx - c.left1.x(),
      camera.fy * p.Y.y() * iz + camera.cy - c.left1.y(), disparity + views.offset - c.disparity0,
      disparity * iz + views.offset - c.disparity1;
  return p;
}

template <int kColumns>
Eigen::Matrix<double, 4, kColumns> point_jacobian(const Views& views, const PointState& point) {
  const ScaledJacobian<kColumns> scaled = scaled_point_jacobian<kColumns>(views, point);
  const Eigen::Matrix<double, 3, kColumns> rows =
      projection_jacobian(views, point).leftCols<scaled.RowsAtCompileTime>().lazyProduct(scaled);
  Eigen::Matrix<double, 4, kColumns> J = spread_rows<kColumns>(rows);
  J(2, kDisparity) = 1.0;
  if constexpr (kColumns == kUnknowns) {
    J(2, kOffset) = 1.0;
    J(3, kOffset) = 1.0;
  }
  return J;
}

template Eigen::Matrix<double, 4, kUnknowns> point_jacobian<kUnknowns>(const Views&,
                                                                       const PointState&);
template Eigen::Matrix<double, 4, kMotionUnknowns> point_jacobian<kMotionUnknowns>(
    const Views&, const PointState&);

Eigen::Matrix<double, 4, 2> left0_jacobian(const Views& views, const PointState& point) {
  const Eigen::Matrix<double, 3, 2> rows =
      projection_jacobian(views, point).leftCols<3>() * scaled_point_left0_jacobian(views);
  return spread_rows<2>(rows);
}

Eigen::Matrix<double, 4, 2> left0_mixed_derivative(const Views& views,
                                                   const PointState& point,
                                                   const PointVector& q) {
  const Eigen::Matrix<double, 5, 1> along_q = scaled_point_jacobian<kUnknowns>(views, point) * q;
  const Eigen::Matrix<double, 3, 2> Y_left0 = scaled_point_left0_jacobian(views);
  // d(Y x theta + Y_focal x)/d(left0): the terms of dY along q that depend on the ray.
  const Eigen::Matrix<double, 3, 2> turned =
      -lie::skew(q.segment<3>(3)) * Y_left0 - q[kFocal] * Y_left0;

  Eigen::Matrix<double, 3, 2> rows = projection_jacobian(views, point).leftCols<3>() * turned;
  for (int r = 0; r < 3; ++r) {
    const Matrix5 C = projection_curvature(views, point, Eigen::Vector3d::Unit(r));
    rows.row(r) += along_q.transpose() * C.leftCols<3>() * Y_left0;
  }
  return spread_rows<2>(rows);
}

template <int kColumns>
Eigen::Matrix<double, kColumns, kColumns> curvature(const Views& views,
                                                    const PointState& point,
                                                    const Eigen::Vector4d& f) {
  const Eigen::Vector3d f_projection(f[0], f[1], f[3]);
  const ScaledJacobian<kColumns> J = scaled_point_jacobian<kColumns>(views, point);
  constexpr int kInner = ScaledJacobian<kColumns>::RowsAtCompileTime;
  const ScaledJacobian<kColumns> CJ = projection_curvature(views, point, f_projection)
                                          .topLeftCorner<kInner, kInner>()
                                          .lazyProduct(J);
  Eigen::Matrix<double, kColumns, kColumns> H = J.transpose().lazyProduct(CJ);

  // Second derivative of Y itself: Exp(-tau) to second order, its mixed terms with d and focal.
  const Eigen::Vector3d g =
      projection_jacobian(views, point).leftCols<3>().transpose() * f_projection;
  const Eigen::Vector3d& Y = point.Y;
  const double inverse_depth = point.disparity * views.inverse_focal_baseline;
  const Eigen::Matrix3d theta_rho = -0.5 * inverse_depth * lie::skew(g);
  H.template block<3, 3>(3, 0) += theta_rho;
  H.template block<3, 3>(0, 3) += theta_rho.transpose();
  H.template block<3, 3>(3, 3) += 0.5 * (Y * g.transpose() + g * Y.transpose());
  H.template block<3, 3>(3, 3).diagonal().array() -= g.dot(Y);
  Eigen::Matrix<double, 6, 1> pose_disparity;
  pose_disparity << -views.inverse_focal_baseline * g, -views.Y_disparity.cross(g);
  H.template block<6, 1>(0, kDisparity) += pose_disparity;
  H.template block<1, 6>(kDisparity, 0) += pose_disparity.transpose();
  if constexpr (kColumns == kUnknowns) {
    const Eigen::Vector3d turn_focal = -point.Y_focal.cross(g);
    H.template block<3, 1>(3, kFocal) += turn_focal;
    H.template block<1, 3>(kFocal, 3) += turn_focal.transpose();
    H(kFocal, kFocal) -= 2.0 * g.dot(point.Y_focal);
  }
  return H;
}

template PointMatrix curvature<kUnknowns>(const Views&, const PointState&, const Eigen::Vector4d&);
template Eigen::Matrix<double, kMotionUnknowns, kMotionUnknowns> curvature<kMotionUnknowns>(
    const Views&, const PointState&, const Eigen::Vector4d&);

}  // namespace imslam::vo::detail
