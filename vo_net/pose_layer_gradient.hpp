#pragma once

#include <Eigen/Core>
#include <optional>
#include <vector>

#include "vo_net/pose_layer.hpp"

namespace imslam::vo {

/// dL/d(every number of a Correspondence), same units inverted.
struct CorrespondenceGradient {
  Eigen::Vector2d left0 = Eigen::Vector2d::Zero();
  Eigen::Vector2d left1 = Eigen::Vector2d::Zero();
  double disparity0 = 0.0;
  double disparity1 = 0.0;
  /// Entries taken as independent; symmetric.
  Eigen::Matrix2d flow_information = Eigen::Matrix2d::Zero();
  double disparity0_information = 0.0;
  double disparity1_information = 0.0;
  double weight = 0.0;
};

struct PoseLayerGradient {
  std::vector<CorrespondenceGradient> correspondences;
  double disparity_offset = 0.0;  ///< dL/d(offset) [1/px]
};

/// Pull-back of solve_pose(): from dL/d(tangent of T_body0_body1) to dL/d(input).
///
/// The solution x = [pose, all disparities] makes the cost's gradient vanish, F(x, z) = 0, so
///
///   q = H^-1 dL/dx,   dL/dz = -(dF/dz)^T q,   H = exact Hessian, d_k eliminated one by one
///
/// (implicit function theorem; nothing is unrolled). Second derivatives of projection and kernel
/// are included. The noise scale that fixes the width of the kernel counts as a constant.
///
/// `correspondences`, `camera` and `options` are those of the solve that gave `result`. Empty where
/// there is no derivative: result not valid, not stationary, or Hessian not positive definite.
std::optional<PoseLayerGradient> pose_layer_gradient(const Correspondences& correspondences,
                                                     const StereoCamera& camera,
                                                     const PoseLayerOptions& options,
                                                     const PoseLayerResult& result,
                                                     const Eigen::Matrix<double, 6, 1>& dL_dpose);

}  // namespace imslam::vo
