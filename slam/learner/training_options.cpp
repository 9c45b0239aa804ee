#include "slam/learner/training_options.hpp"

#include "slam/learner/bounds.hpp"

namespace imslam::learner {

void TrainingOptions::describe_training(Config& config) {
  config.field("seed", seed, "of the first weights and whatever else is drawn");
  config.field("steps", steps, "of the optimiser");
  config.field("batch", batch, "samples per step, one tape each");
  config.field("rate", rate, "learning rate after the warm-up, then half a cosine to 0");
  config.field("warm_up", warm_up, "[steps]");
  config.field("weight_decay", weight_decay, "of AdamW");
  config.field("clip", clip, "largest norm of the gradient");
  config.field("average", average, "decay of the averaged weights, which are the result");
  config.field("validation_every", validation_every, "[steps]");
  config.field("validation_samples", validation_samples, "of other seeds");
  config.field("checkpoint_every", checkpoint_every, "[steps]");
  config.field("patience", patience, "validations without gain that end the training; 0: never");
  config.field("guard", guard, "weights given by --start are the result unless it gains on them");
}

void TrainingOptions::validate_training(const std::string& section) const {
  const auto within = [&section](const char* key, double value, double low, double high) {
    require_within(section + "." + key, value, low, high);
  };
  within("steps", steps, 1, 1e8);
  within("batch", batch, 1, 1024);
  within("rate", rate, 0.0, 1.0);
  within("warm_up", warm_up, 0, steps);
  within("weight_decay", weight_decay, 0.0, 1.0);
  within("clip", clip, 1e-6, 1e6);
  within("average", average, 0.0, 0.99999);
  within("validation_every", validation_every, 1, 1e8);
  within("validation_samples", validation_samples, 2, 10000);
  within("checkpoint_every", checkpoint_every, 1, 1e8);
  within("patience", patience, 0, 1e8);
}

}  // namespace imslam::learner
