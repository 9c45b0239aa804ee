#pragma once

#include <cstddef>
#include <vector>

#include "imu_net/imu_buffer.hpp"
#include "slam/sensors/imu.hpp"
#include "slam/sensors/trajectory.hpp"
#include "slam/training/truth_gravity.hpp"

namespace imslam::training {

struct JumpOptions {
  double smallest_m = 0.015;    ///< [m] smaller ones are noise
  double times_typical = 10.0;  ///< [1] nor is a jump what is below so many times the median step
  double largest_step_s = 0.5;  ///< [s] the truth counts as broken over a longer gap
};

/// Poses before which the truth jumps: real ground truth does, where a tracker loses its target or
/// takes corrections in. Seen as a step that leaves the neighbours' by more than the accelerometer
/// allows: with b_k the bend at pose k (truth_bend.hpp), step k -> k + 1 is wrong by
/// |b_k - b_{k+1}| / 2.
std::vector<std::size_t> find_jumps(imu::ImuRange samples,
                                    const ImuNoise& noise,
                                    const Trajectory& truth,
                                    const GravityFit& gravity,
                                    const JumpOptions& options = {});

}  // namespace imslam::training
