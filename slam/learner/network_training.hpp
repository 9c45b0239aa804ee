#pragma once

#include <filesystem>
#include <optional>
#include <string>

#include "slam/base/process_group.hpp"
#include "slam/learner/training_options.hpp"
#include "slam/learner/training_record.hpp"
#include "slam/nn/model_card.hpp"
#include "slam/nn/training/data_parallel.hpp"
#include "slam/nn/training/gradients.hpp"
#include "slam/nn/training/optimizer.hpp"
#include "slam/nn/weights_io.hpp"

namespace imslam::learner {

/// A look at the averaged weights, for the folder of a training.
struct ValidationRecord {
  double loss = 0.0;  ///< what chooses among weights
  std::string text;   ///< one line for people
  std::string row;    ///< figures, comma separated, in the order of log_columns()
};

/// Trains one network, or several as one list (nn::clip_network_norms tells them apart):
///
///   step k: samples batch k ... batch (k + 1) - 1, one tape each  ->  mean gradient, clipped  ->
///   AdamW with a cosine rate  ->  running average of the weights
///
/// Equal options give equal bytes for any number of threads and however often the training was
/// interrupted (on processors with the same instruction set). A step whose gradient is not finite,
/// or whose samples all went without, changes nothing and is counted. Samples that learn through a
/// solver: see ImperativeTraining.
class NetworkTraining {
 public:
  NetworkTraining(const NetworkTraining&) = delete;  // the parameters belong to a network within
  NetworkTraining& operator=(const NetworkTraining&) = delete;
  virtual ~NetworkTraining() = default;

  const TrainingOptions& common_options() const { return common_; }
  /// After the last step, or earlier by common_options().patience.
  bool done() const { return step_ >= common_.steps || out_of_patience(); }
  bool out_of_patience() const {
    return common_.patience > 0 && looks_without_gain_ >= common_.patience;
  }
  int step_count() const { return step_; }
  int skipped_steps() const { return skipped_.steps(); }
  const SkipCounts& skipped() const { return skipped_; }

  /// One step; returns the mean loss of the batch.
  double step();
  const StepRecord& last_step() const { return record_; }

  /// Takes note of a look; true if it is the best so far.
  bool note_look(double loss);
  /// Of all looks so far, kept in checkpoints.
  double best_loss() const { return best_loss_; }

  /// The guard: the loss of the weights that the training began with, noted as the first look.
  void note_start(double loss);
  std::optional<double> start_loss() const { return start_loss_; }

  /// Of the averaged weights.
  virtual ValidationRecord look() = 0;
  virtual std::string log_columns() const = 0;  ///< comma separated

  /// The task of the network: "match_network" for match_network.safetensors.
  virtual std::string name() const = 0;
  /// All but the metrics, which are those of the last validation, and the command.
  virtual nn::ModelCard card() const = 0;

  /// All that is needed to go on bit by bit.
  void save(const std::filesystem::path& file);
  /// Throws InputError(kModel) if the checkpoint belongs to other options or is damaged.
  void restore(const std::filesystem::path& file);

  /// Begins with these weights instead of random ones.
  void start_from(const std::filesystem::path& weights);

  /// The averaged weights in float16 with their card.
  void write_weights(const std::filesystem::path& file, nn::ModelCard card);

 protected:
  /// `options_text`: what the weights depend on; a checkpoint of another text is refused.
  NetworkTraining(const TrainingOptions& options, std::string options_text);

  /// Once, before all else: the parameters of the network that a derived class holds.
  void adopt(const nn::ParameterList<float>& parameters);

  /// The batch falls into parts that the processes of a group share: see shared_batch(). All ranks
  /// hold the same weights and call the same functions in the same order; `group` lives longer.
  /// sample_loss() and tally() are then about the parts that are this rank's own.
  void share_batches(ProcessGroup& group, std::size_t parts);

  /// Before each step, on the calling thread.
  virtual void prepare_step() {}
  /// The loss of one sample of the present step; called from several threads at once.
  virtual nn::Var sample_loss(nn::Tape<float>& tape, std::size_t slot) = 0;
  /// After each step, on the calling thread: e.g. a surrogate learns from the batch.
  virtual void finish_step() {}
  /// Of the batch that has just run.
  virtual BatchTally tally() const { return {}; }

  /// What else a training must remember, e.g. a Memory.
  virtual void save_more(nn::WeightsWriter&) const {}
  virtual void restore_more(const nn::WeightsFile&) {}

  /// Runs look_at() while the network has the averaged weights; before the first step there are
  /// only the weights themselves.
  template <typename LookAt>
  auto with_average(const LookAt& look_at) {
    swap_average();
    auto result = look_at();
    swap_average();
    return result;
  }

 private:
  void swap_average();
  double run_batch();
  bool scale_to_used_samples(double& loss);
  void save_counts(nn::WeightsWriter& writer) const;
  void restore_counts(const nn::WeightsFile& checkpoint);

  TrainingOptions common_;
  std::string options_text_;
  nn::ParameterList<float> parameters_;
  std::optional<nn::DataParallel<float>> batch_;
  ProcessGroup* group_ = nullptr;  ///< null: one process has it all
  std::size_t parts_ = 1;
  nn::Adam<float> optimizer_;
  nn::WeightAverage<float> average_;
  nn::Gradients<float> gradients_;
  std::string parent_sha256_;
  int step_ = 0;
  SkipCounts skipped_;
  StepRecord record_;
  double best_loss_ = 1e300;
  std::optional<double> start_loss_;
  int looks_without_gain_ = 0;
};

/// The text without the lines of keys that say only when to stop and what to hand back.
std::string without_stop_keys(const std::string& yaml);

/// The options that weights depend on as text: not how often they are looked at.
template <typename Options>
std::string text_of_training(Options options) {
  const TrainingOptions defaults;
  options.validation_every = defaults.validation_every;
  options.validation_samples = defaults.validation_samples;
  options.checkpoint_every = defaults.checkpoint_every;
  Config config;
  config.section("train", options);
  return without_stop_keys(config.to_yaml());
}

}  // namespace imslam::learner
