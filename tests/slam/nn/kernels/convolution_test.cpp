#include "slam/nn/kernels/convolution.hpp"

#include <gtest/gtest.h>

#include <cstring>
#include <string>

#include "slam/base/error.hpp"
#include "slam/base/parallel.hpp"
#include "slam/nn/kernels/instruction_set.hpp"
#include "tests/slam/nn/kernels/guarded_array.hpp"
#include "tests/slam/nn/kernels/odd_shapes.hpp"
#include "tests/slam/nn/kernels/reference_convolution.hpp"

namespace imslam::nn {
namespace {

using testing::Array;
using testing::GuardedArray;

constexpr int kOddShapes = 250;
constexpr Activation kActivations[] = {Activation::kNone, Activation::kRelu,
                                       Activation::kLeakyRelu};

/// Runs `check` once for every instruction set of this machine.
template <typename Check>
void for_each_instruction_set(const Check& check) {
  const InstructionSet before = selected_instruction_set();
  for (const InstructionSet set : available_instruction_sets()) {
    SCOPED_TRACE(name(set));
    select_instruction_set(set);
    check();
  }
  select_instruction_set(before);
}

/// Runs `check(shape, random, workspace)` for many odd shapes, the scratch memory full of NaN.
template <typename Check>
void for_each_odd_shape(const Check& check) {
  Workspace workspace;
  Random random(5);
  for (int i = 0; i < kOddShapes; ++i) {
    const ConvolutionShape shape = testing::odd_shape(random);
    SCOPED_TRACE(shape.text());
    testing::spoil(workspace);
    check(shape, random, workspace);
    if (::testing::Test::HasFailure()) return;  // one shape is enough to read
  }
}

TEST(Convolution, RejectsAKernelLargerThanThePaddedInput) {
  ConvolutionShape shape;
  shape.in_width = 4;
  shape.kernel_width = 5;
  EXPECT_THROW(shape.validate(), ContractError);
  shape.padding_x = 1;
  EXPECT_NO_THROW(shape.validate());
}

TEST(Convolution, ForwardEqualsTheDefinitionForOddShapes) {
  for_each_odd_shape([](const ConvolutionShape& shape, Random& random, Workspace& workspace) {
    GuardedArray x(testing::whole_numbers(random, shape.input_size()));
    GuardedArray w(testing::whole_numbers(random, shape.weight_size()));
    const bool biased = random.chance(0.7);
    const auto outputs = static_cast<std::size_t>(shape.out_channels);
    const Array b = biased ? testing::whole_numbers(random, outputs) : Array();
    const Activation activation = kActivations[random.integer(0, 2)];
    const Array expected = testing::reference_forward(shape, x.values(), w.values(), b, activation);
    for_each_instruction_set([&] {
      GuardedArray y(shape.output_size());
      const float* bias = biased ? b.data() : nullptr;
      convolution_forward(shape, x.data(), w.data(), bias, activation, y.data(), &workspace);
      EXPECT_TRUE(y.values() == expected);
      EXPECT_TRUE(y.guards_are_intact());
      GuardedArray again(shape.output_size());
      const PackedWeights packed(shape, w.data(), bias);
      convolution_forward(shape, x.data(), packed, activation, again.data(), &workspace);
      EXPECT_TRUE(again.values() == expected) << "packed weights";
    });
  });
}

TEST(Convolution, BackwardDataEqualsTheDefinitionForOddShapes) {
  for_each_odd_shape([](const ConvolutionShape& shape, Random& random, Workspace& workspace) {
    GuardedArray w(testing::whole_numbers(random, shape.weight_size()));
    GuardedArray dy(testing::whole_numbers(random, shape.output_size()));
    const Array expected = testing::reference_backward_data(shape, w.values(), dy.values());
    for_each_instruction_set([&] {
      GuardedArray dx(shape.input_size());
      convolution_backward_data(shape, w.data(), dy.data(), dx.data(), &workspace);
      EXPECT_TRUE(dx.values() == expected);
      EXPECT_TRUE(dx.guards_are_intact());
    });
  });
}

TEST(Convolution, BackwardWeightsEqualsTheDefinitionForOddShapes) {
  for_each_odd_shape([](const ConvolutionShape& shape, Random& random, Workspace& workspace) {
    GuardedArray x(testing::whole_numbers(random, shape.input_size()));
    GuardedArray dy(testing::whole_numbers(random, shape.output_size()));
    const Array expected = testing::reference_backward_weights(shape, x.values(), dy.values());
    const Array expected_bias = testing::reference_backward_bias(shape, dy.values());
    for_each_instruction_set([&] {
      GuardedArray dw(shape.weight_size());
      GuardedArray db(static_cast<std::size_t>(shape.out_channels));
      convolution_backward_weights(shape, x.data(), dy.data(), dw.data(), db.data(), &workspace);
      EXPECT_TRUE(dw.values() == expected);
      EXPECT_TRUE(db.values() == expected_bias);
      EXPECT_TRUE(dw.guards_are_intact() && db.guards_are_intact());
      GuardedArray without_bias(shape.weight_size());
      convolution_backward_weights(shape, x.data(), dy.data(), without_bias.data(), nullptr,
                                   &workspace);
      EXPECT_TRUE(without_bias.values() == expected);
    });
  });
}

/// A layer of the size that networks have: many strips and chunks.
ConvolutionShape large_shape(int in_channels, int out_channels, int stride) {
  ConvolutionShape shape;
  shape.batch = 2;
  shape.in_height = 45;
  shape.in_width = 190;
  shape.in_channels = in_channels;
  shape.out_channels = out_channels;
  shape.kernel_height = shape.kernel_width = 3;
  shape.stride_y = shape.stride_x = stride;
  shape.padding_y = shape.padding_x = 1;
  return shape;
}

struct Results {
  Array y, dx, dw, db;
};

Results all_passes(const ConvolutionShape& shape, std::uint64_t seed, int threads) {
  set_thread_count(threads);
  Random random(seed);
  const auto normal = [&random](std::size_t count) {
    Array values(count);
    for (float& value : values) value = static_cast<float>(random.normal());
    return values;
  };
  const Array x = normal(shape.input_size());
  const Array w = normal(shape.weight_size());
  const Array dy = normal(shape.output_size());
  Results r{Array(dy.size()), Array(x.size()), Array(w.size()),
            Array(static_cast<std::size_t>(shape.out_channels))};
  convolution_forward(shape, x.data(), w.data(), nullptr, Activation::kRelu, r.y.data());
  convolution_backward_data(shape, w.data(), dy.data(), r.dx.data());
  convolution_backward_weights(shape, x.data(), dy.data(), r.dw.data(), r.db.data());
  set_thread_count(0);
  return r;
}

bool same_bytes(const Array& a, const Array& b) {
  return a.size() == b.size() && std::memcmp(a.data(), b.data(), a.size() * sizeof(float)) == 0;
}

TEST(Convolution, GivesTheSameBytesForOneAndTwoThreads) {
  for_each_instruction_set([] {
    for (const auto& [inputs, outputs, stride] : {std::array{1, 16, 1}, std::array{20, 40, 2}}) {
      const ConvolutionShape shape = large_shape(inputs, outputs, stride);
      const Results one = all_passes(shape, 3, 1);
      const Results two = all_passes(shape, 3, 2);
      EXPECT_TRUE(same_bytes(one.y, two.y));
      EXPECT_TRUE(same_bytes(one.dx, two.dx));
      EXPECT_TRUE(same_bytes(one.dw, two.dw));
      EXPECT_TRUE(same_bytes(one.db, two.db));
    }
  });
}

TEST(Convolution, RefusesWeightsPackedForAnotherShape) {
  const ConvolutionShape shape = large_shape(3, 8, 1);
  const Array w(shape.weight_size());
  const PackedWeights packed(shape, w.data(), nullptr);
  const ConvolutionShape other = large_shape(4, 8, 1);
  const Array x(other.input_size());
  Array y(other.output_size());
  EXPECT_THROW(convolution_forward(other, x.data(), packed, Activation::kNone, y.data()),
               ContractError);
}

}  // namespace
}  // namespace imslam::nn
