#include "slam/training/pretrain_options.hpp"

#include "slam/training/bounds.hpp"

namespace imslam::training {

void PretrainVoOptions::describe(Config& config) {
  describe_training(config);
  config.field("ramp", ramp, "share of the steps until degradations have full strength");
  config.field("own_chain", own_chain, "share of the triplets without teacher forcing, at last");
  config.field("teacher", teacher, "share of the steps until that is reached");
  config.field("freeze_norms", freeze_norms, "share of the steps with norms over the batch");
  config.section("triplets", triplets);
  config.section("augmentation", augmentation);
  config.section("queries", queries);
  config.section("loss", loss);
}

void PretrainVoOptions::validate() const {
  validate_training();
  require_within("train.ramp", ramp, 0.0, 1.0);
  require_within("train.own_chain", own_chain, 0.0, 1.0);
  require_within("train.teacher", teacher, 0.0, 1.0);
  require_within("train.freeze_norms", freeze_norms, 0.0, 1.0);
  triplets.validate();
  augmentation.validate();
  queries.validate();
  loss.validate();
}

}  // namespace imslam::training
