#pragma once

#include <filesystem>
#include <functional>
#include <optional>
#include <string>

#include "slam/base/config.hpp"
#include "slam/learner/network_training.hpp"

namespace imslam::learner {

/// What to do in which folder.
struct TrainingRequest {
  std::filesystem::path folder;
  bool resume = false;                 ///< go on from the checkpoint, if there is one
  bool force = false;                  ///< throw an earlier training away
  std::string force_flag = "--force";  ///< as people ask for it
  bool writes = true;                  ///< false: another process of the group does
  std::filesystem::path start;         ///< weights to begin with; empty: random ones
  std::string command;                 ///< as typed, for the model card
  /// Called after every step with the steps done, all steps and a note for people; false: stop in
  /// good order.
  std::function<bool(int done, int steps, const std::string& note)> keep_going;
  std::function<void(const std::string& line)> tell;  ///< validations, as they come
};

struct TrainingOutcome {
  bool stopped = false;  ///< by keep_going; the checkpoint allows to go on
  int steps = 0;
  int skipped = 0;      ///< steps that changed nothing
  std::string omitted;  ///< what was left out and why, for people; empty: nothing
  bool early = false;   ///< ended by patience
  /// Guarded only: the held-out loss of the given weights. Not gained: they are the result.
  std::optional<double> loss_before;
  double loss_after = 0.0;  ///< of the result; 1e300 if there was no look
  bool gained() const { return !loss_before || loss_after < *loss_before; }
  std::string best;  ///< the validation of the weights that were kept
  std::filesystem::path weights;
};

/// Makes the folder, and without `resume` clears it of an earlier training of that name. Throws
/// InputError(kOutput) if it holds one and neither `resume` nor `force` was asked for.
void prepare_training_folder(const TrainingRequest& request, const std::string& name);

/// Whether there is anything to go on from.
bool has_checkpoint(const std::filesystem::path& folder);

/// Trains in a folder that anybody can stop and go on with:
///
///   config.yaml              all options
///   checkpoint.safetensors   every checkpoint_every steps and at the end, all or nothing
///   NAME.safetensors         the weights with the least validation loss so far, float16
///   log.csv                  the validations
///
/// With options.guard, weights given by `start` are looked at first (step 0) and stay the result
/// unless a later look is better.
///
/// Throws InputError: kOutput on a folder that is in use, kModel on a checkpoint of other options.
TrainingOutcome run_training(NetworkTraining& training,
                             const std::string& config_yaml,
                             const TrainingRequest& request);

/// The same for Training(options), e.g. run_training<PretrainVo>(options, request).
/// Throws InputError(kUsage) on bad options.
template <typename Training, typename Options>
TrainingOutcome run_training(const Options& options, const TrainingRequest& request) {
  Training training(options);
  Options printed = options;
  Config config;
  config.section("train", printed);
  return run_training(training, config.to_yaml(), request);
}

}  // namespace imslam::learner
