#pragma once

#include <vector>

#include "imu_net/imu_buffer.hpp"
#include "imu_net/midpoint_integrator.hpp"
#include "slam/sensors/imu.hpp"

namespace imslam::imu {

/// The samples whose mean, (1 - share_after) before + share_after after, a step integrates.
struct StepSource {
  const ImuSample* before = nullptr;
  const ImuSample* after = nullptr;  ///< the same as `before` where one sample is held
  double share_after = 0.0;
};

/// What preintegrate() did, step by step: all that its derivatives need. May be used again for the
/// next interval, which saves its memory.
struct PreintegrationRecord {
  ImuRange samples;
  std::vector<RecordedStep> steps;  ///< none: the motion is not valid
  std::vector<StepSource> sources;  ///< one per step
};

}  // namespace imslam::imu
