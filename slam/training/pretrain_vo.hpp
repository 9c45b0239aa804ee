#pragma once

#include <memory>
#include <string>
#include <vector>

#include "slam/learner/network_training.hpp"
#include "slam/training/match_validation.hpp"
#include "slam/training/pretrain_options.hpp"
#include "slam/training/triplet_generator.hpp"

namespace imslam::training {

/// Trains the matching network; a sample is a triplet.
class PretrainVo : public learner::NetworkTraining {
 public:
  explicit PretrainVo(const PretrainVoOptions& options);

  /// Of the averaged weights.
  ValidationResult validate();

  learner::ValidationRecord look() override;
  std::string log_columns() const override;
  std::string name() const override { return "match_network"; }
  nn::ModelCard card() const override;

 private:
  void prepare_step() override;
  nn::Var sample_loss(nn::Tape<float>& tape, std::size_t slot) override;

  PretrainVoOptions options_;
  TripletGenerator generator_;
  Augmentation augmentation_;
  vo::MatchNetwork<float> network_;
  std::vector<Triplet> slots_;                   ///< one per sample of a batch: keeps its memory
  std::unique_ptr<MatchValidation> validation_;  ///< made when first asked for
};

}  // namespace imslam::training
