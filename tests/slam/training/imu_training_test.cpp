#include "slam/training/imu_training.hpp"

#include <gtest/gtest.h>

#include "slam/base/error.hpp"
#include "slam/nn/weights_io.hpp"
#include "tests/slam/learner/training_checks.hpp"
#include "tests/support/temp_dir.hpp"
#include "tests/support/test_data.hpp"

namespace imslam::training {
namespace {

using imslam::testing::TempDir;
using imslam::testing::test_data;

ImuTrainingOptions small_training(int steps) {
  ImuTrainingOptions options;
  options.steps = steps;
  options.batch = 3;
  options.windows = 3;
  options.most_window_s = 3.0;
  options.warm_up = 2;
  options.validation_every = 4;
  options.validation_samples = 4;
  options.checkpoint_every = 2;
  options.simulation.rate_hz = 100.0;
  options.simulation.min_duration_s = 10.0;
  options.simulation.max_duration_s = 15.0;
  return options;
}

TEST(ImuTraining, LearnsToCorrectUnseenSensors) {
  ImuTrainingOptions options = small_training(40);
  options.batch = 8;
  options.windows = 6;
  options.validation_samples = 24;
  options.simulation.min_duration_s = 12.0;
  options.simulation.max_duration_s = 25.0;
  ImuTraining training(options);
  training.step();
  const double before = training.look().loss;
  while (!training.done()) training.step();
  EXPECT_LT(training.look().loss, before - 0.5);
  EXPECT_EQ(training.skipped_steps(), 0);
}

TEST(ImuTraining, ThreadsDoNotChangeABit) {
  learner::testing::expect_threads_change_nothing<ImuTraining>(small_training(3));
}

TEST(ImuTraining, StoppedAnywhereItGoesOnBitByBit) {
  learner::testing::expect_resume_bit_by_bit<ImuTraining>(small_training(8),
                                                          "imu_network.safetensors");
}

/// The tensors of a training's result.
nn::WeightsFile trained_weights(const ImuTrainingOptions& options) {
  const TempDir dir;
  learner::TrainingRequest request;
  request.folder = dir.path() / "run";
  return nn::WeightsFile::read(learner::run_training<ImuTraining>(options, request).weights);
}

TEST(ImuTraining, OnSimulationTheOffsetOfOneSensorStaysZero) {
  nn::Tensor<float> offset({3, 1, 2});
  trained_weights(small_training(4)).read_into("sensor_offset", offset);
  EXPECT_EQ(offset.array().abs().maxCoeff(), 0.0F);
}

TEST(ImuTraining, OnRealLogsItLearnsTheirSensor) {
  const auto log = test_data() / "euroc_imu/V102";
  IMSLAM_NEEDS(test_data() / "euroc_imu");
  ImuTrainingOptions options = small_training(4);
  options.logs = log.string();
  options.crop_s = 10.0;
  options.sensor_offset = true;
  const nn::WeightsFile weights = trained_weights(options);
  nn::Tensor<float> offset({3, 1, 2});
  weights.read_into("sensor_offset", offset);
  EXPECT_GT(offset.array().abs().maxCoeff(), 0.0F);
  EXPECT_NE(weights.card().data.find("V102"), std::string::npos);
}

TEST(ImuTraining, ALogThatIsNotThereIsAnError) {
  ImuTrainingOptions options = small_training(1);
  options.logs = "nowhere/at_all";
  EXPECT_THROW(ImuTraining{options}, InputError);
}

TEST(CorrectionSample, WindowsLieWithinTheLogAndAreTrue) {
  const InertialLogGenerator generator(small_training(1).simulation);
  CorrectionSample sample;
  make_correction_sample(generator.make(3), {20, 0.1, 5.0}, Random(1), sample);
  EXPECT_GT(sample.task.windows.size(), 15U);
  EXPECT_EQ(sample.frames.size(), sample.task.frame_times.size());
  for (const ImuMotion& window : sample.task.windows) {
    EXPECT_GE(window.time0_ns, sample.log.truth.front().time_ns);
    EXPECT_LE(window.time1_ns, sample.log.truth.back().time_ns);
    EXPECT_LT(window.time0_ns, window.time1_ns);
    EXPECT_LE(window.dt_s, 5.1);
  }
}

TEST(CorrectionSample, ACropKeepsWhatLiesInside) {
  const InertialLog log = InertialLogGenerator(small_training(1).simulation).make(0);
  const InertialLog part = cropped(log, 2.0, 3.0);
  ASSERT_FALSE(part.samples.empty());
  ASSERT_FALSE(part.truth.empty());
  const std::int64_t start_ns = log.truth.front().time_ns + 2'000'000'000;
  EXPECT_GE(part.samples.front().time_ns, start_ns);
  EXPECT_LE(part.samples.back().time_ns, start_ns + 3'000'000'000);
  EXPECT_GE(part.truth.front().time_ns, start_ns);
  EXPECT_LE(part.truth.back().time_ns, start_ns + 3'000'000'000);
}

}  // namespace
}  // namespace imslam::training
