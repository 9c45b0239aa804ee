#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "slam/nn/model_card.hpp"
#include "slam/nn/training/data_parallel.hpp"
#include "slam/nn/training/gradients.hpp"
#include "slam/nn/training/optimizer.hpp"
#include "slam/training/match_validation.hpp"
#include "slam/training/pretrain_options.hpp"
#include "slam/training/triplet_generator.hpp"

namespace imslam::training {

/// Trains the matching network:
///
///   step k: triplets batch k ... batch (k + 1) - 1, one tape each  ->  mean gradient, clipped  ->
///   AdamW with a cosine rate  ->  running average of the weights
///
/// Equal options give equal bytes for any number of threads and however often the training was
/// interrupted (on processors with the same instruction set). A step whose gradient is not finite
/// changes nothing and is counted.
class PretrainVo {
 public:
  explicit PretrainVo(const PretrainVoOptions& options);
  PretrainVo(const PretrainVo&) = delete;  // the list of parameters points into the network
  PretrainVo& operator=(const PretrainVo&) = delete;

  bool done() const { return step_ >= options_.steps; }
  int step_count() const { return step_; }
  int skipped_steps() const { return skipped_; }

  /// One step; returns the mean loss of the batch.
  double step();

  /// Of the averaged weights.
  ValidationResult validate();

  /// All that is needed to go on bit by bit.
  void save(const std::filesystem::path& file);
  /// Throws InputError(kModel) if the checkpoint belongs to other options or is damaged.
  void restore(const std::filesystem::path& file);

  /// Begins with these weights instead of random ones.
  void start_from(const std::filesystem::path& weights);

  /// The averaged weights in float16 with their card.
  void write_weights(const std::filesystem::path& file, nn::ModelCard card);

  const std::string& data_description() const { return generator_.description(); }
  const std::string& parent_sha256() const { return parent_sha256_; }
  double best_loss = 1e300;  ///< of all validations so far, kept in checkpoints

 private:
  nn::Var sample_loss(nn::Tape<float>& tape, std::size_t slot);

  PretrainVoOptions options_;
  std::string options_text_;
  Random random_;
  TripletGenerator generator_;
  Augmentation augmentation_;
  vo::MatchNetwork<float> network_;
  nn::ParameterList<float> parameters_;
  nn::DataParallel<float> batch_;
  nn::Adam<float> optimizer_;
  nn::WeightAverage<float> average_;
  nn::Gradients<float> gradients_;
  std::vector<Triplet> slots_;                   ///< one per sample of a batch: keeps its memory
  std::unique_ptr<MatchValidation> validation_;  ///< made when first asked for
  std::string parent_sha256_;
  int step_ = 0;
  int skipped_ = 0;
};

}  // namespace imslam::training
