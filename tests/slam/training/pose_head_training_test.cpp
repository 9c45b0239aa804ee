#include "slam/training/pose_head_training.hpp"

#include <gtest/gtest.h>

#include "slam/learner/training_run.hpp"
#include "slam/nn/weights_io.hpp"
#include "tests/slam/learner/training_checks.hpp"
#include "tests/support/temp_dir.hpp"

namespace imslam::training {
namespace {

using imslam::testing::TempDir;

PoseHeadTrainingOptions small_training(int steps) {
  PoseHeadTrainingOptions options;
  options.steps = steps;
  options.batch = 3;
  options.fields = 2;
  options.warm_up = 2;
  options.validation_every = 4;
  options.validation_samples = 20;
  options.checkpoint_every = 2;
  return options;
}

TEST(PoseHeadTraining, LearnsTheMotionOfUnseenFields) {
  PoseHeadTrainingOptions options = small_training(120);
  options.batch = 4;
  options.fields = 8;
  options.rate = 2e-3;
  options.validation_samples = 100;
  PoseHeadTraining training(options);
  training.step();
  const PoseHeadQuality before = training.validate();
  while (!training.done()) training.step();
  const PoseHeadQuality after = training.validate();
  EXPECT_LT(after.loss, before.loss - 1.0);
  EXPECT_LT(after.rotation_mdeg, 0.8 * before.rotation_mdeg);
  EXPECT_EQ(training.skipped_steps(), 0);
}

TEST(PoseHeadTraining, ThreadsDoNotChangeABit) {
  learner::testing::expect_threads_change_nothing<PoseHeadTraining>(small_training(3));
}

TEST(PoseHeadTraining, StoppedAnywhereItGoesOnBitByBit) {
  learner::testing::expect_resume_bit_by_bit<PoseHeadTraining>(small_training(8),
                                                               "pose_head.safetensors");
}

TEST(PoseHeadTraining, TheCardSaysWhatWasDone) {
  const TempDir dir;
  learner::TrainingRequest request;
  request.folder = dir.path() / "run";
  request.command = "imslam train pose_head";
  const auto outcome = learner::run_training<PoseHeadTraining>(small_training(2), request);
  const nn::ModelCard card = nn::WeightsFile::read(outcome.weights).card();
  EXPECT_EQ(card.command, request.command);
  EXPECT_NE(card.data.find("12 synthetic flow fields"), std::string::npos) << card.data;
  EXPECT_NE(card.metrics.find("rotation"), std::string::npos) << card.metrics;
}

}  // namespace
}  // namespace imslam::training
