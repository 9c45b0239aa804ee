#pragma once

#include <optional>

#include "slam/adaptation/adaptation_options.hpp"
#include "slam/sensors/device_calibration.hpp"
#include "slam/system/slam_result.hpp"

namespace imslam::adaptation {

/// The device as a run's solution has it. What the graph did not estimate, or hardly better than
/// was known before, or what hardly differs from it, stays as the run assumed it, as does what
/// `options` hold: with a regression
/// head that learns, the offset of disparities makes up for its errors and runs away with it. The
/// numbers are kept within DeviceBounds; `assumed` is what the run began with.
///
/// A gyro whose scale is off by a percent, as those of phones are, looks like a focal length that
/// is, and one whose axes are askew like a turned camera: only a gyro that is known for small
/// biases (system.trusted_gyro_bias) may correct these two.
DeviceCalibration refined_device(const system::SlamResult& result,
                                 const DeviceCalibration& assumed,
                                 const std::optional<ImuNoise>& imu,
                                 const system::SlamOptions& slam,
                                 const AdaptationOptions& options);

}  // namespace imslam::adaptation
