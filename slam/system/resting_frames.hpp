#pragma once

#include <cstddef>
#include <vector>

#include "imu_net/static_detector.hpp"
#include "slam/system/measurements.hpp"

namespace imslam::system {

/// Frames where the body rests: the IMU shows nothing, and vision gets nowhere within a second or
/// two. An IMU cannot tell rest from a smooth journey, nor one frame of vision from a slow one; so
/// motions are chained, and where they end must be nearer than a body of `sigma` [m/s] could have
/// come, and than vision's own error.
std::vector<std::size_t> resting_frames(const Measurements& measurements,
                                        double sigma,
                                        const imu::StaticDetectorOptions& still);

}  // namespace imslam::system
