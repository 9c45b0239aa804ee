#include <gtest/gtest.h>

#include <cmath>

#include "slam/base/parallel.hpp"
#include "slam/nn/layers/conv.hpp"
#include "slam/nn/layers/gru.hpp"
#include "slam/nn/layers/linear.hpp"
#include "slam/nn/layers/norm.hpp"
#include "slam/nn/ops/activation.hpp"
#include "slam/nn/ops/layout.hpp"
#include "slam/nn/ops/losses.hpp"
#include "slam/nn/ops/reduce.hpp"
#include "slam/nn/training/data_parallel.hpp"
#include "slam/nn/training/gradients.hpp"
#include "slam/nn/training/optimizer.hpp"
#include "slam/nn/training/schedule.hpp"

namespace imslam::nn {
namespace {

constexpr Index kFrames = 4;
constexpr Index kSize = 12;
constexpr std::size_t kBatch = 8;

struct Sample {
  Tensor<float> frames{Shape{kFrames, kSize, kSize, 1}};
  Tensor<float> velocity{Shape{1, 2}};  ///< [pixels per frame]
};

/// A blob that crosses a small image at constant velocity.
Sample make_sample(Random random) {
  Sample sample;
  const double vx = random.uniform(-1.0, 1.0);
  const double vy = random.uniform(-1.0, 1.0);
  const double x0 = random.uniform(4.0, 8.0) - 1.5 * vx;
  const double y0 = random.uniform(4.0, 8.0) - 1.5 * vy;
  sample.velocity[0] = static_cast<float>(vx);
  sample.velocity[1] = static_cast<float>(vy);
  Index at = 0;
  for (Index t = 0; t < kFrames; ++t) {
    for (Index i = 0; i < kSize; ++i) {
      for (Index j = 0; j < kSize; ++j, ++at) {
        const double dx = static_cast<double>(j) - x0 - vx * static_cast<double>(t);
        const double dy = static_cast<double>(i) - y0 - vy * static_cast<double>(t);
        sample.frames[at] = static_cast<float>(std::exp(-(dx * dx + dy * dy) / 4.0));
      }
    }
  }
  return sample;
}

/// Convolutions per frame, a recurrent unit over the frames, the velocity at the end: visual
/// odometry of one blob.
struct TinyOdometry {
  explicit TinyOdometry(Random random)
      : conv1(1, 8, 3, ConvolutionOptions::square(2, 1), random),
        norm(8),
        conv2(8, 8, 3, ConvolutionOptions::square(2, 1), random),
        frame(3 * 3 * 8, 16, random),
        gru(16, 16, random),
        head(16, 2, random) {
    initialise_constant(head.weight, 0.0);
    conv1.collect(parameters, "conv1.");
    norm.collect(parameters, "norm.");
    conv2.collect(parameters, "conv2.");
    frame.collect(parameters, "frame.");
    gru.collect(parameters, "gru.");
    head.collect(parameters, "head.");
  }

  Var forward(Tape<float>& tape, Var frames) {
    const Var a = leaky_relu(tape, norm.forward(tape, conv1.forward(tape, frames)));
    const Var b = leaky_relu(tape, conv2.forward(tape, a));
    const Var features = tanh(tape, frame.forward(tape, reshape(tape, b, {1, kFrames, 72})));
    const Var states = gru.forward(tape, features, gru.zero_state(tape, 1));
    return head.forward(tape, last_state(tape, states));
  }

  Conv2d<float> conv1;
  BatchNorm<float> norm;
  Conv2d<float> conv2;
  Linear<float> frame;
  Gru<float> gru;
  Linear<float> head;
  ParameterList<float> parameters;
};

struct Outcome {
  double first_loss = 0.0;
  double last_loss = 0.0;  ///< mean of the last ten steps
  std::vector<float> weights;
};

Outcome train(int threads, int tapes, int steps) {
  set_thread_count(threads);
  const Random random(42);
  TinyOdometry network(random.fork(0));
  DataParallel<float> batches(network.parameters, tapes);
  Gradients<float> gradients = zero_gradients(network.parameters);
  Adam<float> adam;
  const CosineSchedule schedule{1e-2, steps, 10, 0.0};
  Outcome outcome;
  for (int step = 0; step < steps; ++step) {
    const auto loss_of = [&](Tape<float>& tape, std::size_t i) {
      const auto stream = static_cast<std::uint64_t>(step) * kBatch + i + 1;
      const Sample sample = make_sample(random.fork(stream));
      const Var y = network.forward(tape, tape.constant(sample.frames));
      return mean(tape, squared_error(tape, y, tape.constant(sample.velocity)));
    };
    const double loss = batches.run(kBatch, loss_of, gradients);
    clip_network_norms(network.parameters, gradients, 1.0);
    adam.step(network.parameters, gradients, schedule.rate(step));
    if (step == 0) outcome.first_loss = loss;
    if (step >= steps - 10) outcome.last_loss += loss / 10.0;
  }
  for (const auto* parameter : network.parameters) {
    const auto& value = parameter->value;
    outcome.weights.insert(outcome.weights.end(), value.data(), value.data() + value.size());
  }
  set_thread_count(0);
  return outcome;
}

TEST(Training, ATinyVisualOdometryLearnsItsTask) {
  const Outcome outcome = train(2, 4, 400);
  EXPECT_GT(outcome.first_loss, 0.1);
  EXPECT_LT(outcome.last_loss, 0.003) << "from " << outcome.first_loss;
}

TEST(Training, EqualBytesForOneAndTwoThreadsAndAnyNumberOfTapes) {
  const Outcome reference = train(1, 4, 30);
  EXPECT_EQ(train(2, 4, 30).weights, reference.weights);
  EXPECT_EQ(train(2, 3, 30).weights, reference.weights);
  EXPECT_EQ(train(1, 1, 30).weights, reference.weights);
}

TEST(DataParallel, IsTheMeanOverTheSamples) {
  Parameter<double> w(Shape{1});
  w.value[0] = 2.0;
  ParameterList<double> list;
  list.add("w", w);
  DataParallel<double> batches(list, 2);
  Gradients<double> gradients = zero_gradients(list);
  const auto loss = [&](Tape<double>& tape, std::size_t i) {
    const Tensor<double> target({1}, {static_cast<double>(i)});
    return sum(tape, squared_error(tape, tape.parameter(w), tape.constant(target)));
  };
  EXPECT_DOUBLE_EQ(batches.run(3, loss, gradients), (4.0 + 1.0 + 0.0) / 3.0);
  EXPECT_DOUBLE_EQ(gradients[0][0], (4.0 + 2.0 + 0.0) / 3.0);
}

TEST(DataParallel, ASampleWhoseLossIsNotANumberLeavesRunningStatisticsAlone) {
  BatchNorm<float> norm(1);
  ParameterList<float> list;
  norm.collect(list, "");
  DataParallel<float> batches(list, 2);
  Gradients<float> gradients = zero_gradients(list);
  const auto loss = [&](Tape<float>& tape, std::size_t i) {
    const Tensor<float> x({2, 1}, {i == 1 ? std::nanf("") : 1.0F, 3.0F});
    return mean(tape, norm.forward(tape, tape.constant(x)));
  };
  EXPECT_TRUE(std::isnan(batches.run(2, loss, gradients)));
  EXPECT_FLOAT_EQ(norm.running_mean.value[0], 0.1F * 2.0F);  // of the other sample
  EXPECT_FLOAT_EQ(norm.running_variance.value[0], 0.9F + 0.1F * 2.0F);
}

}  // namespace
}  // namespace imslam::nn
