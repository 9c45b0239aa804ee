#pragma once

#include "slam/sensors/imu.hpp"

namespace imslam::imu {

enum class SampleHealth {
  kGood,
  kSaturated,  ///< at or beyond the range of the sensor: the truth was at least that
  kBroken,     ///< not finite
};

inline SampleHealth sample_health(const ImuSample& sample, const ImuNoise& noise) {
  if (!sample.angular_velocity.allFinite() || !sample.linear_acceleration.allFinite()) {
    return SampleHealth::kBroken;
  }
  const bool inside = sample.angular_velocity.cwiseAbs().maxCoeff() < noise.gyro_range &&
                      sample.linear_acceleration.cwiseAbs().maxCoeff() < noise.accel_range;
  return inside ? SampleHealth::kGood : SampleHealth::kSaturated;
}

}  // namespace imslam::imu
