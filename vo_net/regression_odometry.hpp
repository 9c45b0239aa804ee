#pragma once

#include <memory>
#include <string>

#include "slam/base/config.hpp"
#include "vo_net/pose_head.hpp"
#include "vo_net/pose_layer.hpp"
#include "vo_net/scale_corrector.hpp"

namespace imslam::vo {

struct RegressionOptions {
  std::string weights;  ///< file; empty: the pose head that the program was shipped with
  ScaleOptions scale;

  void describe(Config& config);
  void validate() const;
};

/// The published way from matches to motion, the alternative to solve_pose():
///
///   matches --FlowGrid--> PoseHead --> R_left0_left1, direction d, sigmas
///           --------------correct_scale--------------> s
///   T_left0_left1 = (R, s d)
///
/// Covariance, to first order, from what the network says of theta and d and what the corrector
/// says of s; the errors of s that come from those of theta and d are not counted twice:
///
/// (correlation of dp with dtheta not claimed, see there)
///
///   dp = (s I + d J_direction^T) dd + d J_rotation^T dtheta + d e_s,   e_s ~ N(0, sigma_s^2)
class RegressionHead {
 public:
  RegressionHead(const RegressionOptions& options, std::shared_ptr<const PoseHead<float>> network);

  /// What solve_pose() gives, from the same arguments; of `limits` only min_inliers and the largest
  /// sigmas count, there is no start. The network makes no statement about the disparity offset
  /// (offset_information = 0). Never throws on bad data.
  PoseLayerResult solve(const Correspondences& correspondences,
                        const StereoCamera& camera,
                        const PoseLayerOptions& limits,
                        double disparity_offset = 0.0) const;

 private:
  struct Regressed;
  Regressed regress(const Correspondences& correspondences,
                    const StereoCamera& camera,
                    double disparity_offset) const;

  RegressionOptions options_;
  std::shared_ptr<const PoseHead<float>> network_;
};

}  // namespace imslam::vo
