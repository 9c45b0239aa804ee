#pragma once

#include <optional>
#include <vector>

#include "slam/sensors/motion.hpp"
#include "slam/system/measurements.hpp"

namespace imslam::system {

/// Whether a gyro that turned by `gyro` over the same time, variance of all axes together [rad^2],
/// says something else:
///
///   angle of gyro^-1 R_vision > max(0.5 deg, 8 sigma)
bool contradicts(const lie::SO3d& gyro, double gyro_variance, const RelativeMotion& vision);

/// Frames to which vision and gyro report different rotations: a splice, a piece played backwards,
/// a large thing that moves with the camera. Per frame of the measurements.
///
/// `inertial`: per interval, at the bias found. Motions over several intervals are compared as a
/// whole. False where one of the two is missing or degraded.
std::vector<bool> rotation_conflicts(const Measurements& measurements,
                                     const std::vector<ImuMotion>& inertial);

/// The measurements without the visual motions that begin or end in a flagged frame: images can
/// show another place than the body's, a gyro cannot, so the IMU bridges the stretch. Empty if
/// nothing is flagged, or half of all frames or more: then one of the two sensors, or how they are
/// mounted, is wrong as a whole, and it is not known which.
std::optional<Measurements> without_conflicts(const Measurements& measurements,
                                              const std::vector<bool>& conflicts);

}  // namespace imslam::system
