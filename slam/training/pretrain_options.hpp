#pragma once

#include "slam/base/config.hpp"
#include "slam/learner/training_options.hpp"
#include "slam/training/augmentation.hpp"
#include "slam/training/match_sample.hpp"
#include "slam/training/triplet_generator.hpp"
#include "vo_net/match_loss.hpp"

namespace imslam::training {

/// Supervised training of the matching network on synthetic triplets.
struct PretrainVoOptions : learner::TrainingOptions {
  double ramp = 0.15;         ///< share of the steps until degradations have full strength
  double own_chain = 0.7;     ///< share of the triplets without teacher forcing, at last,
  double teacher = 0.3;       ///< reached after this share of the steps
  double freeze_norms = 0.7;  ///< share of the steps after which norms use running statistics

  TripletOptions triplets;
  AugmentationOptions augmentation;
  QueryOptions queries;
  vo::MatchLossOptions loss;

  void describe(Config& config);
  void validate() const;  ///< Throws InputError(kUsage) naming key, value and bound.
};

}  // namespace imslam::training
