#include "slam/training/pretrain_options.hpp"

#include "slam/training/bounds.hpp"

namespace imslam::training {

void PretrainVoOptions::describe(Config& config) {
  config.field("seed", seed, "of the first weights and the query points");
  config.field("steps", steps, "of the optimiser");
  config.field("batch", batch, "triplets per step");
  config.field("rate", rate, "learning rate after the warm-up, then half a cosine to 0");
  config.field("warm_up", warm_up, "[steps]");
  config.field("weight_decay", weight_decay, "of AdamW");
  config.field("clip", clip, "largest norm of the gradient");
  config.field("average", average, "decay of the averaged weights, which are the result");
  config.field("ramp", ramp, "share of the steps until degradations have full strength");
  config.field("own_chain", own_chain, "share of the triplets without teacher forcing, at last");
  config.field("teacher", teacher, "share of the steps until that is reached");
  config.field("freeze_norms", freeze_norms, "share of the steps with norms over the batch");
  config.field("validation_every", validation_every, "[steps]");
  config.field("validation_samples", validation_samples, "triplets, half of them degraded");
  config.field("checkpoint_every", checkpoint_every, "[steps]");
  config.section("triplets", triplets);
  config.section("augmentation", augmentation);
  config.section("queries", queries);
  config.section("loss", loss);
}

void PretrainVoOptions::validate() const {
  require_within("train.steps", steps, 1, 1e8);
  require_within("train.batch", batch, 1, 1024);
  require_within("train.rate", rate, 0.0, 1.0);
  require_within("train.warm_up", warm_up, 0, steps);
  require_within("train.weight_decay", weight_decay, 0.0, 1.0);
  require_within("train.clip", clip, 1e-6, 1e6);
  require_within("train.average", average, 0.0, 0.99999);
  require_within("train.ramp", ramp, 0.0, 1.0);
  require_within("train.own_chain", own_chain, 0.0, 1.0);
  require_within("train.teacher", teacher, 0.0, 1.0);
  require_within("train.freeze_norms", freeze_norms, 0.0, 1.0);
  require_within("train.validation_every", validation_every, 1, 1e8);
  require_within("train.validation_samples", validation_samples, 2, 10000);
  require_within("train.checkpoint_every", checkpoint_every, 1, 1e8);
  triplets.validate();
  augmentation.validate();
  queries.validate();
  loss.validate();
}

}  // namespace imslam::training
