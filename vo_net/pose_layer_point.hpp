#pragma once

#include <Eigen/Core>

#include "slam/lie/se3.hpp"
#include "slam/sensors/calibration.hpp"
#include "vo_net/correspondence.hpp"
#include "vo_net/robust_kernel.hpp"

namespace imslam::vo::detail {

/// Unknowns that one point depends on, in this order: pose tangent (6), its true disparity in
/// left0, the constant disparity offset, the relative error of the focal length.
inline constexpr int kPose = 0;
inline constexpr int kDisparity = 6;
inline constexpr int kOffset = 7;
inline constexpr int kFocal = 8;
inline constexpr int kUnknowns = 9;
inline constexpr int kMotionUnknowns = 7;  ///< without the calibration: what the solver moves
using PointVector = Eigen::Matrix<double, kUnknowns, 1>;
using PointMatrix = Eigen::Matrix<double, kUnknowns, kUnknowns>;
using PointJacobian = Eigen::Matrix<double, 4, kUnknowns>;

/// What all points of one evaluation share.
struct Views {
  Views(const StereoCamera& camera_in, const lie::SE3d& T_left0_left1, double offset_px)
      : camera(camera_in),
        R_left1_left0(T_left0_left1.rotation().inverse().matrix()),
        Y_disparity(-(R_left1_left0 * T_left0_left1.translation()) /
                    (camera_in.fx * camera_in.baseline_m)),
        inverse_focal_baseline(1.0 / (camera_in.fx * camera_in.baseline_m)),
        offset(offset_px) {}

  const StereoCamera& camera;
  Eigen::Matrix3d R_left1_left0;
  Eigen::Vector3d Y_disparity;    ///< dY/d(disparity)
  double inverse_focal_baseline;  ///< inverse depth per px of disparity
  double offset;                  ///< [px]
};

/// One point at one estimate. It is held as Y = p_left1 * (inverse depth in left0), which stays
/// finite for points at infinity:
///
///   Y = R_left1_left0 (ray - inverse_depth t_left0),   inverse_depth = disparity / (fx baseline)
///   e = [fx Yx/Yz + cx - u1,  fy Yy/Yz + cy - v1,  d + offset - disparity0,
///        d/Yz + offset - disparity1]
///
/// A focal length wrong by the factor 1 + x scales the ray and the projection, but not the law of
/// depth: the calibration of a stereo pair knows fx baseline, not its factors. All is evaluated at
/// x = 0.
struct PointState {
  Eigen::Vector3d Y;
  Eigen::Vector3d Y_focal;  ///< dY/d(focal error)
  double disparity = 0.0;   ///< d [px], without the offset
  Eigen::Vector4d e;        ///< [px]
  bool in_front = false;    ///< false: Y and e are not to be used
};

PointState evaluate_point(const Views& views, const Correspondence& c, double disparity);

/// de/d(the first kColumns unknowns): kUnknowns or kMotionUnknowns.
template <int kColumns = kUnknowns>
Eigen::Matrix<double, 4, kColumns> point_jacobian(const Views& views, const PointState& point);

/// de/d(left0) (4x2).
Eigen::Matrix<double, 4, 2> left0_jacobian(const Views& views, const PointState& point);

/// d(de/d(unknowns) q)/d(left0) (4x2): how the residual's change along q depends on left0.
Eigen::Matrix<double, 4, 2> left0_mixed_derivative(const Views& views,
                                                   const PointState& point,
                                                   const PointVector& q);

/// sum_r f_r d2 e_r / d(the first kColumns unknowns)^2 with f = Omega e: what Gauss-Newton leaves
/// out.
template <int kColumns = kUnknowns>
Eigen::Matrix<double, kColumns, kColumns> curvature(const Views& views,
                                                    const PointState& point,
                                                    const Eigen::Vector4d& f);

/// Omega a, the information matrix of [left1 disparity0 disparity1] being block diagonal.
inline Eigen::Vector4d apply_information(const Correspondence& c, const Eigen::Vector4d& a) {
  Eigen::Vector4d result;
  result << c.flow_information * a.head<2>(), c.disparity0_information * a[2],
      c.disparity1_information * a[3];
  return result;
}

}  // namespace imslam::vo::detail
