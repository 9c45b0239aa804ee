#include <gtest/gtest.h>

#include <malloc.h>

#include <string>

#include "slam/nn/layers/attention.hpp"
#include "slam/nn/layers/conv.hpp"
#include "slam/nn/layers/gru.hpp"
#include "slam/nn/layers/norm.hpp"
#include "slam/nn/ops/activation.hpp"
#include "slam/nn/ops/arithmetic.hpp"
#include "slam/nn/ops/correlation.hpp"
#include "slam/nn/ops/layout.hpp"
#include "slam/nn/ops/pooling.hpp"
#include "slam/nn/ops/reduce.hpp"
#include "slam/nn/ops/resize.hpp"
#include "slam/nn/ops/sampling.hpp"
#include "slam/nn/weights_io.hpp"
#include "tests/support/counted_memory.hpp"

namespace imslam::nn {
namespace {

using testing::counted_memory;

/// A bit of everything that a network does per frame.
struct Network {
  explicit Network(Random& random)
      : conv(2, 8, 3, ConvolutionOptions::square(2, 1), random),
        norm(8),
        gru(8, 8, random),
        attention(8, 8, 2, random) {}

  Var forward(Tape<float>& tape, Var image) {
    const Var features = relu(tape, norm.forward(tape, conv.forward(tape, image)));
    const Var up = upsample2_bilinear(tape, max_pool(tape, features, 2, 2));
    const Var volume = cost_volume(tape, features, up, Window::square(1));
    const Var points = tape.constant(query_points);
    const Var queries = bilinear_sample(tape, features, points, Border::kClamp);
    const Var windows =
        correlate_points(tape, queries, up, points, Window::square(1), Centre::kBilinear);
    const Var sequence = gru.forward(tape, queries, gru.zero_state(tape, 1));
    const Var looked = attention.forward(tape, sequence, queries);
    return add(tape, mean(tape, concat(tape, {looked, windows}, -1)), mean(tape, volume));
  }

  Conv2d<float> conv;
  BatchNorm<float> norm;
  Gru<float> gru;
  Attention<float> attention;
  Tensor<float> query_points = Tensor<float>({1, 3, 2}, {1.0F, 2.0F, 3.5F, 0.5F, 2.0F, 3.0F});
};

long allocations_after_the_first_frame(Mode mode) {
  Random random(1);
  Network network(random);
  Tensor<float> image({1, 16, 16, 2});
  image.array() = 0.5F;
  Tape<float> tape(mode);
  long first = 0;
  for (int frame = 0; frame < 4; ++frame) {
    tape.reset();
    const Var y = network.forward(tape, tape.constant(image));
    if (mode == Mode::kTraining) tape.backward(y, tape.copy(y));
    if (frame == 1)
      first = counted_memory().allocations;  // the second: pools of threads have settled
  }
  const long later = counted_memory().allocations - first;
  return mode == Mode::kTraining ? later - 2 * 2
                                 : later;  // copy() allocates a tensor by its nature
}

TEST(Allocation, InferenceAllocatesNothingAfterTheFirstFrames) {
  EXPECT_EQ(allocations_after_the_first_frame(Mode::kInference), 0);
}

TEST(Allocation, TrainingAllocatesNothingEither) {
  EXPECT_LE(allocations_after_the_first_frame(Mode::kTraining), 0);
}

TEST(Allocation, InferenceGivesTheNumbersOfTraining) {
  Random random(1);
  Network network(random);
  network.norm.frozen = true;
  Tensor<float> image({1, 16, 16, 2});
  for (Index i = 0; i < image.size(); ++i) image[i] = static_cast<float>(random.uniform());
  Tape<float> training;
  Tape<float> inference(Mode::kInference);
  EXPECT_EQ(training.number(network.forward(training, training.constant(image))),
            inference.number(network.forward(inference, inference.constant(image))));
}

/// The most memory held while a file is read or refused, the file itself included.
long peak_of(std::string bytes) {
  const long before =
      counted_memory().held_bytes - static_cast<long>(malloc_usable_size(bytes.data()));
  counted_memory().most_held_bytes = counted_memory().held_bytes.load();
  try {
    WeightsFile::parse("m", std::move(bytes));
  } catch (const InputError&) {
    // which it should be
  }
  return counted_memory().most_held_bytes - before;
}

TEST(Allocation, ReadingAWeightFileTakesAtMostTwiceItsSize) {
  const auto file = [](const std::string& json, std::size_t data_bytes) {
    std::string bytes(8 + json.size() + data_bytes, '\0');
    for (unsigned i = 0; i < 8; ++i)
      bytes[i] = static_cast<char>((json.size() >> (8U * i)) & 0xFFU);
    std::copy(json.begin(), json.end(), bytes.begin() + 8);
    return bytes;
  };
  constexpr std::size_t kMany = 1000000;
  std::string sizes;
  for (std::size_t i = 0; i < kMany / 2; ++i) sizes += "1,";
  const std::string tensor = "\"dtype\":\"F32\",\"data_offsets\":[0,4]";
  const std::vector<std::string> files{
      file("{\"a\":{\"shape\":[1]," + tensor + "}}", 4),
      file("{\"a\":{\"shape\":[4611686018427387904]," + tensor + "}}", 4),
      file("{\"a\":{\"shape\":[250000],\"dtype\":\"F32\",\"data_offsets\":[0,1000000]}}", kMany),
      std::string(8, '\xFF') + std::string(kMany, ' '),
      file(std::string(kMany, '['), 0),
      file("{\"a\":{\"shape\":[" + sizes + "1]," + tensor + "}}", 4),
      file("{\"" + std::string(kMany, 'a') + "\":{}}", 0),
      file("{\"__metadata__\":{\"a\":\"" + std::string(kMany, 'a') + "\"}}", 0),
      file("{\"a\":{\"dtype\":\"" + std::string(kMany, 'a') + "\"}}", 0),
  };
  constexpr long kSmallThings = 65536;  // messages, one text of the header
  for (const std::string& bytes : files) {
    const auto size = static_cast<long>(bytes.size());
    EXPECT_LE(peak_of(bytes), 2 * size + kSmallThings) << bytes.substr(8, 40);
  }
}

}  // namespace
}  // namespace imslam::nn
