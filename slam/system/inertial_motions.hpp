#pragma once

#include <functional>
#include <vector>

#include "imu_net/preintegration.hpp"
#include "slam/sensors/motion.hpp"
#include "slam/system/measurements.hpp"

namespace imslam::system {

/// The bias to subtract in the interval that begins at frame i.
using BiasOfFrame = std::function<ImuBias(std::size_t)>;

/// IMU motions between consecutive frames; entry i leads from frame i to i + 1. Parallel.
std::vector<ImuMotion> integrate_intervals(const Measurements& measurements,
                                           const BiasOfFrame& bias,
                                           double time_offset_s,
                                           const imu::PreintegrationOptions& options);

}  // namespace imslam::system
