#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <vector>

namespace imslam::vo {

/// One scene point seen by both rectified pairs, at t-1 (0) and t (1).
///
/// The pixel in left0 is chosen by the matcher and hence exact; what is measured is where it lies
/// in the three other images: left1 (2 numbers) and, on the same row, right0 and right1
/// (disparities).
///
///   z = [u_left1  v_left1  disparity0  disparity1]
struct Correspondence {
  Eigen::Vector2d left0 = Eigen::Vector2d::Zero();  ///< [px]
  Eigen::Vector2d left1 = Eigen::Vector2d::Zero();  ///< [px]
  double disparity0 = 0.0;                          ///< [px] u_left0 - u_right0
  double disparity1 = 0.0;                          ///< [px] u_left1 - u_right1

  Eigen::Matrix2d flow_information = Eigen::Matrix2d::Identity();  ///< [1/px^2] of left1
  double disparity0_information = 1.0;                             ///< [1/px^2]
  double disparity1_information = 1.0;                             ///< [1/px^2], 0: not measured
  double weight = 1.0;                                             ///< confidence in [0, 1]

  std::int64_t track_id = -1;  ///< the same point over several frames, -1 unknown

  /// Which numbers are a network's own answers, which can learn; the others were fitted to pixels.
  struct Learned {
    bool left1 = false;
    bool disparity0 = false;
    bool disparity1 = false;
  } learned;
};

using Correspondences = std::vector<Correspondence>;

}  // namespace imslam::vo
