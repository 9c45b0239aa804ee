#pragma once

#include <cstdint>
#include <vector>

#include "slam/sensors/imu.hpp"

namespace imslam::imu {

/// How wrong the bias of corrected readings may still be: standard deviations, from `time_ns` on
/// until the next one.
struct StampedBiasSigma {
  std::int64_t time_ns = 0;
  ImuBias sigma;  ///< [rad/s], [m/s^2]
};

/// A log after a correction. Raw readings are one too: no variances, no sigmas.
struct CorrectedSamples {
  std::vector<ImuSample> samples;            ///< stamps as measured; variances added
  std::vector<StampedBiasSigma> bias_sigma;  ///< in order of time; empty: nothing is known
};

}  // namespace imslam::imu
