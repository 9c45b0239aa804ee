#pragma once

#include "slam/base/config.hpp"
#include "slam/learner/training_options.hpp"
#include "slam/training/flow_fields.hpp"

namespace imslam::training {

/// Supervised training of the pose head on synthetic flow fields.
struct PoseHeadTrainingOptions : learner::TrainingOptions {
  PoseHeadTrainingOptions() {
    steps = 7000;
    batch = 4;
    rate = 2e-3;
    warm_up = 200;
    validation_every = 500;
    validation_samples = 1024;
  }

  int fields = 8;             ///< flow fields per sample, which share a tape
  double early_weight = 0.3;  ///< of all looks but the last in the loss
  FlowFieldOptions flow;

  void describe(Config& config);
  void validate() const;  ///< Throws InputError(kUsage) naming key, value and bound.
};

}  // namespace imslam::training
