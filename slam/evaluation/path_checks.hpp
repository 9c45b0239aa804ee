#pragma once

#include <string>
#include <vector>

#include "slam/evaluation/associate.hpp"
#include "slam/sensors/trajectory.hpp"

namespace imslam::evaluation {

/// Throws InputError(kEvaluation) naming the pose if a stamp or pose is not finite or a rotation
/// is none (orthonormal to worse than 1e-3), or if there is no pose at all.
void require_evaluable(const PosePath& path);

/// The estimate's poses P = T_world_body carried to another frame of the same rigid body,
/// P T_body_eval: the reference of many sets is of the IMU while odometry tracks a camera.
PosePath moved_to_frame(const PosePath& path, const Eigen::Matrix4d& T_body_eval);

/// Doubts about comparing like with like: the labels of the frames differ, or the orientations
/// differ by one constant, large rotation although the positions agree (camera against body), or
/// the path is so straight that alignment by positions leaves the rotation about it open.
std::vector<std::string> frame_warnings(const MatchedPaths& matched);

}  // namespace imslam::evaluation
