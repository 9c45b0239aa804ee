#pragma once

#include "datasets/check.hpp"
#include "datasets/rotation_comparison.hpp"

namespace imslam::datasets {

/// Exchanged cameras, row differences, and the gyro against the rotations of the images.
void check_vision(Sequence& sequence, int frames, Findings& findings);

/// What a comparison of vision and gyro means for the calibration; nothing if it is not valid.
/// `file` is where the extrinsics stand.
void judge_rotations(const RotationComparison& comparison,
                     const lie::SO3d& R_body_left,
                     const std::string& file,
                     Findings& findings);

}  // namespace imslam::datasets
