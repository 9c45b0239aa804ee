#include "slam/training/pretrain_vo.hpp"

#include <gtest/gtest.h>

#include "slam/base/error.hpp"
#include "slam/base/file.hpp"
#include "slam/learner/training_run.hpp"
#include "slam/nn/weights_io.hpp"
#include "tests/slam/learner/training_checks.hpp"
#include "tests/slam/training/samples.hpp"
#include "tests/support/temp_dir.hpp"

namespace imslam::training {
namespace {

using imslam::testing::TempDir;

PretrainVoOptions small_training(int steps) {
  PretrainVoOptions options;
  options.steps = steps;
  options.batch = 3;
  options.warm_up = 2;
  options.validation_every = 4;
  options.validation_samples = 4;
  options.checkpoint_every = 2;
  options.triplets = quick_options();
  options.triplets.scene.width = 128;
  options.triplets.scene.height = 96;
  options.triplets.scene.most_disparity = 40.0;
  options.triplets.scene.rotation_flow = 20.0;
  options.triplets.scene.parallax_flow = 20.0;
  options.queries.points = 64;
  return options;
}

learner::TrainingRequest request_in(const std::filesystem::path& folder) {
  learner::TrainingRequest request;
  request.folder = folder;
  return request;
}

std::string bytes(const std::filesystem::path& folder, const char* name) {
  return read_file(folder / name);
}

TEST(PretrainVo, LearnsToMatchUnseenScenes) {
  PretrainVoOptions options = small_training(60);
  options.batch = 4;
  options.validation_samples = 8;
  PretrainVo training(options);
  training.step();
  const ValidationResult before = training.validate();
  while (!training.done()) training.step();
  const ValidationResult after = training.validate();
  EXPECT_LT(after.loss, 0.75 * before.loss);
  EXPECT_LT(after.quality[1].median_px, 0.5 * before.quality[1].median_px);
  EXPECT_EQ(training.skipped_steps(), 0);
}

TEST(PretrainVo, ThreadsDoNotChangeABit) {
  learner::testing::expect_threads_change_nothing<PretrainVo>(small_training(3));
}

TEST(TrainingRun, StoppedAnywhereItGoesOnBitByBit) {
  learner::testing::expect_resume_bit_by_bit<PretrainVo>(small_training(8),
                                                         "match_network.safetensors");
}

// A kill leaves a checkpoint that is older than the log: what was done since is done again.
TEST(TrainingRun, AfterAKillTheLogHoldsEachValidationOnce) {
  const TempDir dir;
  const PretrainVoOptions options = small_training(8);
  learner::TrainingRequest request = request_in(dir.path() / "run");
  request.keep_going = [](int done, int, const std::string&) { return done < 2; };
  learner::run_training<PretrainVo>(options, request);
  const auto checkpoint = dir.path() / "run" / "checkpoint.safetensors";
  const std::string old = read_file(checkpoint);
  request.keep_going = nullptr;
  request.resume = true;
  learner::run_training<PretrainVo>(options, request);
  const std::string log = bytes(dir.path() / "run", "log.csv");
  write_file_atomic(checkpoint, old);
  learner::run_training<PretrainVo>(options, request);
  EXPECT_EQ(bytes(dir.path() / "run", "log.csv"), log);
}

TEST(TrainingRun, AnotherTrainingInTheFolderIsRefused) {
  const TempDir dir;
  const learner::TrainingRequest request = request_in(dir.path() / "run");
  learner::run_training<PretrainVo>(small_training(2), request);
  EXPECT_THROW(learner::run_training<PretrainVo>(small_training(2), request), InputError);
  learner::TrainingRequest resume = request;
  resume.resume = true;
  EXPECT_THROW(learner::run_training<PretrainVo>(small_training(3), resume), InputError);
  learner::TrainingRequest force = request;
  force.force = true;
  EXPECT_EQ(learner::run_training<PretrainVo>(small_training(3), force).steps, 3);
}

TEST(TrainingRun, ADamagedCheckpointIsRefused) {
  const TempDir dir;
  learner::TrainingRequest request = request_in(dir.path() / "run");
  learner::run_training<PretrainVo>(small_training(2), request);
  const auto checkpoint = dir.path() / "run" / "checkpoint.safetensors";
  std::string damaged = read_file(checkpoint);
  damaged.resize(damaged.size() / 2);
  write_file_atomic(checkpoint, damaged);
  request.resume = true;
  EXPECT_THROW(learner::run_training<PretrainVo>(small_training(2), request), InputError);
}

TEST(TrainingRun, AStartFromWeightsNamesItsParent) {
  const TempDir dir;
  const auto first =
      learner::run_training<PretrainVo>(small_training(2), request_in(dir.path() / "first"));
  learner::TrainingRequest request = request_in(dir.path() / "second");
  request.start = first.weights;
  const auto second = learner::run_training<PretrainVo>(small_training(2), request);
  EXPECT_EQ(nn::WeightsFile::read(second.weights).card().parent,
            nn::WeightsFile::read(first.weights).data_sha256());
}

}  // namespace
}  // namespace imslam::training
