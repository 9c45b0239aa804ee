#pragma once

#include "datasets/check.hpp"

namespace imslam::datasets {

/// Exchanged cameras, row differences, and gyro and accelerometer against the motion in the images.
void check_vision(Sequence& sequence, int frames, Findings& findings);

}  // namespace imslam::datasets
