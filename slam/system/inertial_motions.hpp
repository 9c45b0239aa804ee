#pragma once

#include <cstdint>
#include <functional>
#include <vector>

#include "imu_net/preintegration.hpp"
#include "slam/sensors/motion.hpp"
#include "slam/system/measurements.hpp"

namespace imslam::system {

/// The bias to subtract in the interval that begins at frame i.
using BiasOfFrame = std::function<ImuBias(std::size_t)>;

/// The IMU's motion from time0_ns to time1_ns [camera's clock], integrated at `bias`.
///
/// J_time_offset is the mean slope over +-25 ms, not the slope at the ends: there the noise of two
/// readings would look like a change of motion. The offset would then seem to be known, and be
/// pulled to where it fits that noise (errors in variables), the more so the more it vibrates.
ImuMotion integrate_interval(const Measurements& measurements,
                             std::int64_t time0_ns,
                             std::int64_t time1_ns,
                             const ImuBias& bias,
                             double time_offset_s,
                             const imu::PreintegrationOptions& options);

/// IMU motions between consecutive frames; entry i leads from frame i to i + 1. Parallel.
std::vector<ImuMotion> integrate_intervals(const Measurements& measurements,
                                           const BiasOfFrame& bias,
                                           double time_offset_s,
                                           const imu::PreintegrationOptions& options);

}  // namespace imslam::system
