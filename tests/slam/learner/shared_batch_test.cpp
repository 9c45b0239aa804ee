#include "slam/learner/shared_batch.hpp"

#include <gtest/gtest.h>

#include <cstring>
#include <string>

#include "slam/nn/layers/linear.hpp"
#include "slam/nn/ops/reduce.hpp"

namespace imslam::learner {
namespace {

constexpr std::size_t kSamples = 12;
constexpr std::size_t kParts = 3;

/// A layer and what its samples say of it.
struct Task {
  Task() : random(5), layer(2, 2, random) {
    layer.collect(parameters, "");
    gradients = nn::zero_gradients(parameters);
  }

  static nn::Var loss(nn::Tape<float>& tape, const nn::Linear<float>& layer, std::size_t sample) {
    Random drawn = Random(11).fork(sample);
    nn::Tensor<float> x({1, 2});
    for (nn::Index i = 0; i < 2; ++i) {
      x[i] = (sample % 2 == 0 ? 1e3F : 1e-2F) * static_cast<float>(drawn.normal());
    }
    return mean(tape, layer.forward(tape, tape.constant(x)));
  }
  nn::DataParallel<float>::SampleLoss sample_loss() const {
    return [this](nn::Tape<float>& tape, std::size_t sample) { return loss(tape, layer, sample); };
  }
  /// The gradients, then the loss.
  std::string bytes(double mean_loss) const {
    std::string all(reinterpret_cast<const char*>(&mean_loss), sizeof(mean_loss));
    for (const nn::Tensor<float>& gradient : gradients) {
      all.append(reinterpret_cast<const char*>(gradient.data()),
                 static_cast<std::size_t>(gradient.size()) * sizeof(float));
    }
    return all;
  }

  Random random;
  nn::Linear<float> layer;
  nn::ParameterList<float> parameters;
  nn::Gradients<float> gradients;
};

std::string shared_in(ProcessGroup& group, int tapes) {
  Task task;
  nn::DataParallel<float> batch(task.parameters, tapes);
  const double loss =
      shared_batch(group, batch, kSamples, kParts, task.sample_loss(), task.gradients);
  return task.bytes(loss);
}

/// What every rank of `jobs` processes got.
std::vector<std::string> shared_by(int jobs, int tapes = 1) {
  std::vector<std::string> all;
  ProcessOptions options;
  options.jobs = jobs;
  run_in_processes(options, [&](ProcessGroup& group) {
    all = group.gather(shared_in(group, tapes));
    return ExitCode::kOk;
  });
  return all;
}

TEST(SharedBatch, IsTheMeanOverTheWholeBatch) {
  Task task;
  nn::DataParallel<float> batch(task.parameters, 1);
  const auto alone = single_process();
  const double shared =
      shared_batch(*alone, batch, kSamples, kParts, task.sample_loss(), task.gradients);
  const nn::Gradients<float> parts = task.gradients;
  std::vector<std::vector<float>> kept;
  for (const auto& g : parts) kept.emplace_back(g.data(), g.data() + g.size());
  const double whole = batch.run(kSamples, task.sample_loss(), task.gradients);
  EXPECT_NEAR(shared, whole, 1e-5 * std::abs(whole));
  for (std::size_t p = 0; p < kept.size(); ++p) {
    for (std::size_t i = 0; i < kept[p].size(); ++i) {
      const float exact = task.gradients[p][static_cast<nn::Index>(i)];
      EXPECT_NEAR(kept[p][i], exact, 1e-4F * std::abs(exact));
    }
  }
}

TEST(SharedBatch, HasTheSameBytesOnAllRanksForAnyNumberOfThem) {
  const std::string alone = shared_by(1).front();
  for (const int jobs : {2, 3, 4}) {
    for (const std::string& bytes : shared_by(jobs, 2)) EXPECT_TRUE(bytes == alone) << jobs;
  }
}

TEST(SharedBatch, TheTallyCountsTheSamplesOfAllRanks) {
  ProcessOptions options;
  options.jobs = 3;
  BatchTally all;
  run_in_processes(options, [&](ProcessGroup& group) {
    BatchTally own;
    own.refused[0] = group.rank() + 1;
    own.residual = group.rank() == 1 ? 0.5 : 0.25;
    all = shared_tally(group, own);
    return ExitCode::kOk;
  });
  EXPECT_EQ(all.refused[0], 6);
  EXPECT_EQ(all.residual, 0.5);
}

}  // namespace
}  // namespace imslam::learner
