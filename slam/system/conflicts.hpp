#pragma once

#include <vector>

#include "slam/sensors/motion.hpp"
#include "slam/system/measurements.hpp"

namespace imslam::system {

/// Frames to which vision and gyro report different rotations: a splice, a piece played backwards,
/// a large thing that moves with the camera. Per frame of the measurements:
///
///   angle of dR^-1 R_vision > max(0.5 deg, 8 sigma)
///
/// `inertial`: per interval, at the bias found. Motions over several intervals are compared as a
/// whole. False where one of the two is missing or degraded.
std::vector<bool> rotation_conflicts(const Measurements& measurements,
                                     const std::vector<ImuMotion>& inertial);

}  // namespace imslam::system
