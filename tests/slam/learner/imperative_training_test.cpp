#include "slam/learner/imperative_training.hpp"

#include <gtest/gtest.h>

#include <map>

#include "slam/learner/imperative_loss.hpp"
#include "slam/learner/training_run.hpp"
#include "slam/nn/weights_io.hpp"
#include "tests/slam/learner/toy_training.hpp"
#include "tests/slam/learner/training_checks.hpp"
#include "tests/support/numeric_jacobian.hpp"

namespace imslam::learner {
namespace {

using imslam::testing::TempDir;
using testing::ToyOptions;
using testing::ToyTraining;

TrainingRequest request_in(const std::filesystem::path& folder) {
  TrainingRequest request;
  request.folder = folder;
  return request;
}

nn::Tensor<float> bias_of(const std::filesystem::path& weights) {
  nn::Tensor<float> bias(nn::Shape{2});
  nn::WeightsFile::read(weights).read_into("bias", bias);
  return bias;
}

TEST(ImperativeLoss, SendsTheUpperGradientToTheNetwork) {
  nn::Tape<double> tape;
  const nn::Var z = tape.input(nn::Tensor<double>({2}, {0.5, -1.0}));
  UpperGradient upper;
  upper.cost = 7.0;
  upper.gradient = (Vector(2) << 3.0, -4.0).finished();
  const nn::Var loss = imperative_loss(tape, z, upper);
  EXPECT_EQ(numbers_of(tape, z), Vector((Vector(2) << 0.5, -1.0).finished()));
  EXPECT_EQ(tape.number(loss), 7.0);
  tape.backward(loss);
  EXPECT_EQ(tape.gradient_data(z)[0], 3.0);
  EXPECT_EQ(tape.gradient_data(z)[1], -4.0);
}

TEST(ImperativeTraining, LearnsWithoutLabelsThroughTheSolver) {
  ToyTraining training(ToyOptions{});
  const double before = training.look().loss;
  while (!training.done()) training.step();
  const double after = training.look().loss;
  std::printf("toy: held-out loss %.4f -> %.4f\n", before, after);
  EXPECT_LT(after, 0.3 * before);
  EXPECT_TRUE(training.skipped().text().empty());
  EXPECT_GT(training.last_step().gradient_norm, 0.0);
}

TEST(ImperativeTraining, ThreadsDoNotChangeABit) {
  ToyOptions options;
  options.fails_every = 4;
  testing::expect_threads_change_nothing<ToyTraining>(options);
}

TEST(ImperativeTraining, StoppedAnywhereItGoesOnBitByBit) {
  ToyOptions options;
  options.fails_every = 4;
  testing::expect_resume_bit_by_bit<ToyTraining>(options, "toy.safetensors");
}

TEST(ImperativeTraining, SamplesWithoutGradientAreLeftOutOfTheMeanAndCounted) {
  ToyOptions options;
  options.steps = 10;
  options.fails_every = 4;  // 15 of 60 samples
  ToyTraining training(options);
  while (!training.done()) training.step();
  EXPECT_EQ(training.skipped().text(), "15 samples: unconverged solve");
  EXPECT_EQ(training.skipped_steps(), 0);
}

TEST(ImperativeTraining, ARefusedSampleIsAsIfItWereNotInTheBatch) {
  ToyOptions five;
  five.batch = 5;
  ToyOptions six;
  six.fails_every = 6;  // the last of the first batch
  ToyTraining without(five);
  ToyTraining refused(six);
  EXPECT_NEAR(refused.step(), without.step(), 1e-6);
  EXPECT_NEAR(refused.last_step().gradient_norm, without.last_step().gradient_norm, 1e-6);
  EXPECT_LT(refused.last_step().residual, 1e-9);  // of those that were used
}

TEST(ImperativeTraining, AStepWithoutAnyGradientChangesNothing) {
  const TempDir dir;
  ToyOptions options;
  options.steps = 3;
  options.fails_every = 1;
  ToyTraining training(options);
  training.write_weights(dir.path() / "before", {});
  while (!training.done()) training.step();
  training.write_weights(dir.path() / "after", {});
  EXPECT_EQ(training.skipped_steps(), 3);
  EXPECT_EQ(training.skipped().unsolved, 3);
  EXPECT_EQ(read_file(dir.path() / "before"), read_file(dir.path() / "after"));
}

TEST(NetworkTraining, PatienceCountsLooksWithoutGain) {
  ToyOptions options;
  options.patience = 2;
  ToyTraining training(options);
  EXPECT_TRUE(training.note_look(1.0));
  EXPECT_FALSE(training.note_look(1.0));
  EXPECT_TRUE(training.note_look(0.9));
  EXPECT_FALSE(training.note_look(0.95));
  EXPECT_FALSE(training.done());
  EXPECT_FALSE(training.note_look(0.9));
  EXPECT_TRUE(training.done());
}

TEST(TrainingRun, EndsWhenPatienceDoes) {
  const TempDir dir;
  ToyOptions options;
  options.steps = 400;
  options.rate = 0.0;  // nothing gains, but for roundings of the average
  options.patience = 3;
  const auto outcome = run_training<ToyTraining>(options, request_in(dir.path()));
  EXPECT_TRUE(outcome.early);
  EXPECT_FALSE(outcome.stopped);
  EXPECT_LT(outcome.steps, 100);
}

/// Trained weights, and a training that ruins them.
struct Ruin {
  explicit Ruin(const std::filesystem::path& folder)
      : good(run_training<ToyTraining>(ToyOptions{}, request_in(folder / "good")).weights),
        request(request_in(folder / "ruined")) {
    options.rate = 0.9;
    options.warm_up = 0;
    options.steps = 3;
    options.clip = 1e6;
    options.validation_every = 3;
    request.start = good;
  }
  std::filesystem::path good;
  ToyOptions options;
  TrainingRequest request;
};

TEST(TrainingRun, TheGuardKeepsTheGivenWeightsFromAWorseResult) {
  const TempDir dir;
  const Ruin ruin(dir.path());
  const auto outcome = run_training<ToyTraining>(ruin.options, ruin.request);
  ASSERT_TRUE(outcome.loss_before.has_value());
  EXPECT_FALSE(outcome.gained());
  EXPECT_EQ(outcome.loss_after, *outcome.loss_before);
  EXPECT_TRUE((bias_of(outcome.weights).array() == bias_of(ruin.good).array()).all());
}

TEST(TrainingRun, WithoutGuardTheWorseResultIsHandedOut) {
  const TempDir dir;
  Ruin ruin(dir.path());
  ruin.options.guard = false;
  const auto outcome = run_training<ToyTraining>(ruin.options, ruin.request);
  EXPECT_FALSE(outcome.loss_before.has_value());
  EXPECT_FALSE((bias_of(outcome.weights).array() == bias_of(ruin.good).array()).all());
}

TEST(TrainingRun, TheGuardDoesNotStandInTheWayOfAGain) {
  const TempDir dir;
  ToyOptions first;
  first.steps = 4;
  TrainingRequest request = request_in(dir.path() / "second");
  request.start = run_training<ToyTraining>(first, request_in(dir.path() / "first")).weights;
  const auto outcome = run_training<ToyTraining>(ToyOptions{}, request);
  EXPECT_TRUE(outcome.gained());
  EXPECT_LT(outcome.loss_after, *outcome.loss_before);
}

/// A finished training, and another one in the same folder that may throw it away.
struct Restart {
  explicit Restart(const std::filesystem::path& folder) : request(request_in(folder)) {
    options.steps = 4;
    weights = run_training<ToyTraining>(options, request).weights;
    request.force = true;
  }

  /// That it is refused with `code`, and leaves every file as it was.
  void expect_refused(ExitCode code) const {
    const auto contents = [this] {
      std::map<std::string, std::string> files;
      for (const auto& entry : std::filesystem::directory_iterator(request.folder)) {
        files[entry.path().filename().string()] = read_file(entry.path());
      }
      return files;
    };
    const auto before = contents();
    try {
      run_training<ToyTraining>(options, request);
      ADD_FAILURE() << "expected InputError";
    } catch (const InputError& error) {
      EXPECT_EQ(error.code(), code) << error.what();
    }
    EXPECT_EQ(contents(), before);
  }

  ToyOptions options;
  TrainingRequest request;
  std::filesystem::path weights;
};

TEST(TrainingRun, DoesNotThrowAwayTheFileThatItIsToStartFrom) {
  const TempDir dir;
  Restart restart(dir.path());
  for (const auto& name : {restart.weights, dir.path() / "." / restart.weights.filename()}) {
    restart.request.start = name;
    restart.expect_refused(ExitCode::kUsage);
  }
}

TEST(TrainingRun, ThrowsNothingAwayWhereItCannotStart) {
  const TempDir dir;
  Restart restart(dir.path());
  restart.request.start = dir.path() / "gone.safetensors";
  restart.expect_refused(ExitCode::kModel);
  restart.request.start = dir.path() / "log.csv";
  restart.expect_refused(ExitCode::kModel);
}

TEST(TrainingRun, StartsAnewFromACopyOfWhatItThrowsAway) {
  const TempDir dir;
  Restart restart(dir.path() / "training");
  restart.request.start = dir.path() / "copy.safetensors";
  std::filesystem::copy_file(restart.weights, restart.request.start);
  EXPECT_TRUE(run_training<ToyTraining>(restart.options, restart.request).loss_before.has_value());
}

/// The checkpoint as it was written before steps and samples were counted by reason.
void take_counts_away(const std::filesystem::path& file) {
  const auto checkpoint = nn::WeightsFile::read(file);
  nn::WeightsWriter writer;
  for (const nn::TensorEntry& entry : checkpoint.tensors()) {
    const std::string& key = entry.name;
    if (key == "skipped_unsolved" || key == "looks_without_gain" || key.rfind("refused/", 0) == 0) {
      continue;
    }
    if (entry.type == nn::NumberType::kI64) {
      writer.add(key, checkpoint.integer(key));
    } else if (entry.type == nn::NumberType::kF64) {
      nn::Tensor<double> numbers(entry.shape);
      checkpoint.read_into(key, numbers);
      writer.add(key, numbers);
    } else {
      nn::Tensor<float> numbers(entry.shape);
      checkpoint.read_into(key, numbers);
      writer.add(key, numbers);
    }
  }
  writer.write(file, checkpoint.metadata());
}

TEST(NetworkTraining, ACheckpointWithoutCountsByReasonGoesOn) {
  const TempDir dir;
  const ToyOptions options;
  ToyTraining whole(options);
  ToyTraining first(options);
  while (!whole.done()) whole.step();
  for (int i = 0; i < 10; ++i) first.step();
  first.save(dir.path() / "old");
  take_counts_away(dir.path() / "old");
  ToyTraining second(options);
  second.restore(dir.path() / "old");
  while (!second.done()) second.step();
  whole.save(dir.path() / "whole");
  second.save(dir.path() / "second");
  EXPECT_EQ(read_file(dir.path() / "whole"), read_file(dir.path() / "second"));
}

// The keys came later than checkpoints that exist.
TEST(TrainingOptions, PatienceAndGuardDoNotMakeItAnotherTraining) {
  ToyOptions options;
  const std::string text = text_of_training(options);
  options.patience = 5;
  options.guard = false;
  EXPECT_EQ(text_of_training(options), text);
  EXPECT_EQ(text.find("patience"), std::string::npos);
  EXPECT_NE(text.find("fails_every"), std::string::npos);
  EXPECT_EQ(text.back(), '\n');
}

}  // namespace
}  // namespace imslam::learner
