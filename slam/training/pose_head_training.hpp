#pragma once

#include <memory>
#include <string>

#include "slam/learner/network_training.hpp"
#include "slam/training/pose_head_options.hpp"
#include "slam/training/pose_head_validation.hpp"

namespace imslam::training {

/// Trains the pose head; a sample is a handful of flow fields.
class PoseHeadTraining : public learner::NetworkTraining {
 public:
  explicit PoseHeadTraining(const PoseHeadTrainingOptions& options);

  /// Of the averaged weights.
  PoseHeadQuality validate();

  learner::ValidationRecord look() override;
  std::string log_columns() const override { return PoseHeadQuality::columns(); }
  std::string name() const override { return "pose_head"; }
  nn::ModelCard card() const override;

 private:
  nn::Var sample_loss(nn::Tape<float>& tape, std::size_t slot) override;

  PoseHeadTrainingOptions options_;
  FlowFieldGenerator generator_;
  vo::PoseHead<float> network_;
  std::unique_ptr<PoseHeadValidation> validation_;  ///< made when first asked for
};

}  // namespace imslam::training
