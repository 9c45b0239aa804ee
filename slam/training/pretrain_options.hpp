#pragma once

#include "slam/base/config.hpp"
#include "slam/training/augmentation.hpp"
#include "slam/training/match_sample.hpp"
#include "slam/training/triplet_generator.hpp"
#include "vo_net/match_loss.hpp"

namespace imslam::training {

/// Supervised training of the matching network on synthetic triplets.
struct PretrainVoOptions {
  int seed = 1;        ///< of the first weights and the query points
  int steps = 5000;    ///< of the optimiser
  int batch = 16;      ///< triplets per step
  double rate = 3e-3;  ///< learning rate after the warm-up, then half a cosine to 0
  int warm_up = 100;   ///< [steps]
  double weight_decay = 1e-4;
  double clip = 5.0;            ///< largest norm of the gradient
  double average = 0.998;       ///< decay of the averaged weights, which are the result
  double ramp = 0.15;           ///< share of the steps until degradations have full strength
  double own_chain = 0.7;       ///< share of the triplets without teacher forcing, at last,
  double teacher = 0.3;         ///< reached after this share of the steps
  double freeze_norms = 0.7;    ///< share of the steps after which norms use running statistics
  int validation_every = 250;   ///< [steps]
  int validation_samples = 96;  ///< half of them clean, half degraded; of other seeds
  int checkpoint_every = 100;   ///< [steps]

  TripletOptions triplets;
  AugmentationOptions augmentation;
  QueryOptions queries;
  vo::MatchLossOptions loss;

  void describe(Config& config);
  void validate() const;  ///< Throws InputError(kUsage) naming key, value and bound.
};

}  // namespace imslam::training
