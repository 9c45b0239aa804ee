#pragma once

#include <cstddef>
#include <optional>
#include <vector>

#include "slam/lie/se3.hpp"
#include "slam/sensors/motion.hpp"
#include "slam/sensors/trajectory.hpp"

namespace imslam::evaluation {

/// Whether the stated covariances of motions fit to their errors. NEES = e^T C^-1 e.
struct MotionConsistency {
  std::size_t motions = 0;             ///< that truth is known for
  double nees_mean = 0.0;              ///< 6 is right; more: overconfident
  double nees_median = 0.0;            ///< 5.35 is right; a few gross errors do not matter
  double nees_translation_mean = 0.0;  ///< 3 is right
  double nees_rotation_mean = 0.0;     ///< 3 is right
  double share_inside = 0.0;  ///< NEES below the 95 % quantile of chi-square: 0.95 is right
};

/// Truth within 1 ms of both ends of a motion counts as its truth; `T_body_truth` carries the body
/// to the frame that the truth is of. Empty if no motion has truth. The errors of the truth itself
/// count as errors of the motions.
std::optional<MotionConsistency> motion_consistency(const std::vector<RelativeMotion>& motions,
                                                    const PosePath& truth,
                                                    const lie::SE3d& T_body_truth);

}  // namespace imslam::evaluation
