#include "slam/training/pose_head_options.hpp"

#include "slam/training/bounds.hpp"

namespace imslam::training {

void PoseHeadTrainingOptions::describe(Config& config) {
  describe_training(config);
  config.field("fields", fields, "flow fields per sample, which share a tape");
  config.field("early_weight", early_weight, "of all looks but the last in the loss");
  config.section("flow", flow);
}

void PoseHeadTrainingOptions::validate() const {
  validate_training();
  require_within("train.fields", fields, 1, 1024);
  require_within("train.early_weight", early_weight, 0.0, 100.0);
  flow.validate();
}

}  // namespace imslam::training
