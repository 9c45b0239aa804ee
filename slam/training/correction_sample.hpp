#pragma once

#include <cstdint>
#include <vector>

#include "imu_net/correction_loss.hpp"
#include "slam/base/random.hpp"
#include "slam/training/inertial_log.hpp"

namespace imslam::training {

/// A log as the IMU network trains on it. `task` points into `log`: neither copied nor moved apart.
struct CorrectionSample {
  InertialLog log;
  std::vector<imu::ImuFrame> frames;
  imu::CorrectionTask task;
};

/// Which stretches are integrated: lengths log-uniform between the two.
struct WindowDraw {
  int count = 12;
  double least_s = 0.1;
  double most_s = 10.0;
};

/// Frames and windows of a log; fewer windows if it is too short for what was drawn.
void make_correction_sample(InertialLog log,
                            const WindowDraw& draw,
                            Random random,
                            CorrectionSample& sample);

/// The part of a log within [start_s, start_s + length_s] of its truth.
InertialLog cropped(const InertialLog& log, double start_s, double length_s);

}  // namespace imslam::training
