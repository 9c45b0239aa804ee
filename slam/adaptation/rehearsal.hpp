#pragma once

#include <cstdint>

#include "imu_net/imu_network.hpp"
#include "slam/training/inertial_log_generator.hpp"

namespace imslam::adaptation {

/// Keeps the IMU network good for sensors other than the one of this sequence:
/// imu::correction_loss() on a simulated log with exact truth, of a sensor drawn like those that it
/// was trained on. Log `index` depends on the generator's options and `index` alone.
nn::Var rehearsal(nn::Tape<float>& tape,
                  const imu::ImuNetwork<float>& network,
                  const training::InertialLogGenerator& generator,
                  std::uint64_t index);

/// Logs for it: short ones, so that a few per step cost little.
training::InertialLogOptions rehearsal_logs(int seed);

}  // namespace imslam::adaptation
