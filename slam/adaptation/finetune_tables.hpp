#pragma once

#include <string>

#include "slam/adaptation/finetune.hpp"

namespace imslam::adaptation {

/// Before and after, for people: what needs truth has a dash without it.
std::string comparison_table(const EpochScores& before, const EpochScores& after);

/// Sequence by sequence, a few of these figures. Empty for one sequence.
std::string sequences_table(const FinetuneOutcome& outcome);

/// What is taken for true of the device, likewise. Empty if nothing changed.
std::string device_table(const DeviceCalibration& before, const DeviceCalibration& after);

}  // namespace imslam::adaptation
