#pragma once

#include "slam/sensors/imu.hpp"

namespace imslam::imu {

enum class SampleHealth {
  kGood,
  kSaturated,  ///< at or beyond the range of the sensor: the truth was at least that
  kBroken,     ///< not finite, or a negative variance
};

inline bool is_variance(const Eigen::Vector3d& v) { return v.allFinite() && v.minCoeff() >= 0.0; }

inline SampleHealth sample_health(const ImuSample& sample, const ImuNoise& noise) {
  if (!sample.angular_velocity.allFinite() || !sample.linear_acceleration.allFinite()) {
    return SampleHealth::kBroken;
  }
  if (!is_variance(sample.gyro_variance) || !is_variance(sample.accel_variance)) {
    return SampleHealth::kBroken;
  }
  const bool inside = sample.angular_velocity.cwiseAbs().maxCoeff() < noise.gyro_range &&
                      sample.linear_acceleration.cwiseAbs().maxCoeff() < noise.accel_range;
  return inside ? SampleHealth::kGood : SampleHealth::kSaturated;
}

}  // namespace imslam::imu
