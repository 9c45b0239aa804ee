#pragma once

#include <string>
#include <vector>

#include "slam/sensors/calibration.hpp"
#include "slam/system/measurements.hpp"

namespace imslam::system {

/// What a run's own measurements say against the calibration it was given: extrinsics and focal
/// length (gyro against vision), baseline (accelerometer against vision). Empty if all fits, or if
/// too little moved to tell. Looks at the first minute or so.
std::vector<std::string> calibration_doubts(const Measurements& measurements,
                                            const StereoCamera& camera);

}  // namespace imslam::system
