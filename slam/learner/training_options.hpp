#pragma once

#include <string>

#include "slam/base/config.hpp"

namespace imslam::learner {

/// What the training of any network needs; options of a network derive from it.
struct TrainingOptions {
  int seed = 1;        ///< of the first weights and whatever else is drawn
  int steps = 5000;    ///< of the optimiser
  int batch = 16;      ///< samples per step, one tape each
  double rate = 3e-3;  ///< learning rate after the warm-up, then half a cosine to 0
  int warm_up = 100;   ///< [steps]
  double weight_decay = 1e-4;
  double clip = 5.0;            ///< largest norm of the gradient
  double average = 0.998;       ///< decay of the averaged weights, which are the result
  int validation_every = 250;   ///< [steps]
  int validation_samples = 96;  ///< of other seeds
  int checkpoint_every = 100;   ///< [steps]
  int patience = 0;   ///< validations without gain after which the training ends; 0: never
  bool guard = true;  ///< given weights are the result unless the training gains on them

 protected:
  void describe_training(Config& config);
  /// Throws InputError(kUsage) naming key (of that section), value and bound.
  void validate_training(const std::string& section = "train") const;
};

}  // namespace imslam::learner
