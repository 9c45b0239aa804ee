#pragma once

#include "datasets/finding.hpp"
#include "datasets/rotation_comparison.hpp"
#include "datasets/scale_comparison.hpp"

namespace imslam::datasets {

// What a comparison of vision and IMU means for the calibration; nothing if it is not valid.

/// Extrinsics and focal length.
void judge_rotations(const RotationComparison& comparison,
                     const lie::SO3d& R_body_left,
                     Findings& findings);

/// The offset between the clocks of camera and IMU.
void judge_clock(const RotationComparison& comparison, Findings& findings);

/// The baseline.
void judge_scale(const ScaleComparison& comparison, Findings& findings);

}  // namespace imslam::datasets
