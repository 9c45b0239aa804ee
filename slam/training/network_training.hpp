#pragma once

#include <filesystem>
#include <optional>
#include <string>

#include "slam/nn/model_card.hpp"
#include "slam/nn/training/data_parallel.hpp"
#include "slam/nn/training/gradients.hpp"
#include "slam/nn/training/optimizer.hpp"
#include "slam/training/training_options.hpp"

namespace imslam::training {

/// A look at the averaged weights, for the folder of a training.
struct ValidationRecord {
  double loss = 0.0;  ///< what chooses among weights
  std::string text;   ///< one line for people
  std::string row;    ///< figures, comma separated, in the order of log_columns()
};

/// Trains one network:
///
///   step k: samples batch k ... batch (k + 1) - 1, one tape each  ->  mean gradient, clipped  ->
///   AdamW with a cosine rate  ->  running average of the weights
///
/// Equal options give equal bytes for any number of threads and however often the training was
/// interrupted (on processors with the same instruction set). A step whose gradient is not finite
/// changes nothing and is counted.
class NetworkTraining {
 public:
  NetworkTraining(const NetworkTraining&) = delete;  // the parameters belong to a network within
  NetworkTraining& operator=(const NetworkTraining&) = delete;
  virtual ~NetworkTraining() = default;

  const TrainingOptions& common_options() const { return common_; }
  bool done() const { return step_ >= common_.steps; }
  int step_count() const { return step_; }
  int skipped_steps() const { return skipped_; }

  /// One step; returns the mean loss of the batch.
  double step();

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

  double best_loss = 1e300;  ///< of all validations so far, kept in checkpoints

 protected:
  /// `options_text`: what the weights depend on; a checkpoint of another text is refused.
  NetworkTraining(const TrainingOptions& options, std::string options_text);

  /// Once, before all else: the parameters of the network that a derived class holds.
  void adopt(const nn::ParameterList<float>& parameters);

  /// Before each step, on the calling thread.
  virtual void prepare_step() {}
  /// The loss of one sample of the present step; called from several threads at once.
  virtual nn::Var sample_loss(nn::Tape<float>& tape, std::size_t slot) = 0;

  /// Runs look_at() while the network has the averaged weights.
  template <typename LookAt>
  auto with_average(const LookAt& look_at) {
    average_.swap(parameters_);
    auto result = look_at();
    average_.swap(parameters_);
    return result;
  }

 private:
  TrainingOptions common_;
  std::string options_text_;
  nn::ParameterList<float> parameters_;
  std::optional<nn::DataParallel<float>> batch_;
  nn::Adam<float> optimizer_;
  nn::WeightAverage<float> average_;
  nn::Gradients<float> gradients_;
  std::string parent_sha256_;
  int step_ = 0;
  int skipped_ = 0;
};

/// The options that weights depend on as text: not how often they are looked at.
template <typename Options>
std::string text_of_training(Options options) {
  const TrainingOptions defaults;
  options.validation_every = defaults.validation_every;
  options.validation_samples = defaults.validation_samples;
  options.checkpoint_every = defaults.checkpoint_every;
  Config config;
  config.section("train", options);
  return config.to_yaml();
}

}  // namespace imslam::training
