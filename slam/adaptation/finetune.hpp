#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "slam/adaptation/adaptation_training.hpp"
#include "slam/learner/training_run.hpp"

namespace imslam::adaptation {

/// What a fine-tuning came to.
struct FinetuneOutcome {
  learner::TrainingOutcome training;
  std::vector<std::filesystem::path> weights;  ///< one file per network
  EpochScores before;                          ///< of the networks that were given
  EpochScores after;                           ///< of the files in `weights`
  system::RunOutcome zero_shot;
  system::RunOutcome adapted;
};

/// Teaches the networks of a run on its own sequence, in a folder that anybody can stop and go on
/// with (learner::run_training), then runs once with the given networks and once with the result:
///
///   before.safetensors      all parameters as given
///   networks.safetensors    all parameters of the epoch with the least held-out loss
///   weights/NAME.safetensors   the result, one file per network, with model cards
///   checkpoint.safetensors, config.yaml, log.csv
///
/// A new fine-tuning in the same folder throws all results of the earlier one away.
/// With options.guard, a result that does not gain on the given weights in the held-out
/// self-supervised loss is refused: the given weights are the result.
/// Throws what run_sequence() and run_training() throw. Stopped: `weights` is empty.
FinetuneOutcome finetune(const EpochRequest& epoch,
                         const std::string& config_yaml,
                         learner::TrainingRequest request);

/// sha256 over the names and contents of a sequence's input files.
std::string sequence_sha256(const datasets::Sequence& sequence);

/// Before and after, for people: what needs truth has a dash without it.
std::string comparison_table(const EpochScores& before, const EpochScores& after);

/// What is taken for true of the device, likewise. Empty if nothing changed.
std::string device_table(const DeviceCalibration& before, const DeviceCalibration& after);

}  // namespace imslam::adaptation
