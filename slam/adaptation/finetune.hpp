#pragma once

#include <filesystem>
#include <functional>
#include <string>
#include <vector>

#include "slam/adaptation/adaptation_training.hpp"
#include "slam/learner/training_run.hpp"

namespace imslam::adaptation {

/// One sequence before and after.
struct FinetunedSequence {
  std::string name;
  std::size_t frames = 0;
  EpochScores before;  ///< of the networks that were given
  EpochScores after;   ///< of those that are the result
  DeviceCalibration device_before;
  DeviceCalibration device_after;
};

/// What a fine-tuning came to.
struct FinetuneOutcome {
  learner::TrainingOutcome training;
  std::vector<std::filesystem::path> weights;  ///< one file per network
  std::vector<FinetunedSequence> sequences;    ///< on rank 0; empty on the others

  EpochScores before() const;  ///< mean over the sequences
  EpochScores after() const;
};

enum class FinetuneRun { kZeroShot, kAdapted };

/// Who gets the runs before and after: of each sequence on the rank that it belongs to.
using TakeRun = std::function<void(std::size_t sequence, FinetuneRun, system::RunOutcome& run)>;

/// Teaches the networks of a run on its own sequences, one or several at once, in a folder that
/// anybody can stop and go on with (learner::run_training), then runs each sequence once with the
/// given networks and once with the result:
///
///   before.safetensors      all parameters as given
///   networks.safetensors    all parameters of the epoch with the least held-out loss
///   weights/NAME.safetensors   the result, one file per network, with model cards
///   checkpoint.safetensors, config.yaml, log.csv
///
/// A new fine-tuning in the same folder throws all results of the earlier one away, if
/// request.force says that they may go; InputError(kOutput) otherwise. With options.guard, a result
/// that does not gain on the given weights in the held-out self-supervised loss (mean over the
/// sequences) is refused: the given weights are the result.
///
/// Several processes share the sequences out (AdaptationTraining); the folder must be one that all
/// of them see, rank 0 writes there. The result does not depend on how many they are.
/// Throws what run_sequence() and run_training() throw. Stopped: `weights` is empty.
FinetuneOutcome finetune(const std::vector<EpochRequest>& sequences,
                         const std::string& config_yaml,
                         learner::TrainingRequest request,
                         ProcessGroup& group,
                         const TakeRun& take_run);

/// sha256 over the names and contents of a sequence's input files.
std::string sequence_sha256(const datasets::Sequence& sequence);
/// That of the sequence, or of the names and hashes of several.
std::string data_sha256(const std::vector<EpochRequest>& sequences);

}  // namespace imslam::adaptation
