#pragma once

#include <array>
#include <vector>

#include "slam/base/random.hpp"
#include "slam/nn/kernels/convolution.hpp"

namespace imslam::nn::testing {

template <std::size_t N>
int pick(Random& random, const std::array<int, N>& options) {
  return options[static_cast<std::size_t>(random.integer(0, N - 1))];
}

inline double products(const ConvolutionShape& shape) {
  return double(shape.output_size()) * double(shape.weight_size()) / shape.out_channels;
}

/// Every size drawn from what is awkward: tails of channels and pixels, kernels larger than the
/// image, strides larger than the kernel, padding larger than the kernel.
inline ConvolutionShape odd_shape(Random& random) {
  constexpr std::array kChannels = {1, 2, 3, 4, 5, 7, 8, 12, 16, 17, 32, 33, 48, 49, 64, 96};
  constexpr std::array kKernels = {1, 1, 2, 3, 3, 3, 5, 7};
  ConvolutionShape shape;
  do {
    shape.batch = pick(random, std::array{1, 1, 2, 3});
    shape.in_height = pick(random, std::array{1, 2, 3, 5, 8, 13});
    shape.in_width = static_cast<int>(random.integer(1, 70));
    shape.in_channels = pick(random, kChannels);
    shape.out_channels = pick(random, kChannels);
    shape.kernel_height = pick(random, kKernels);
    shape.kernel_width = pick(random, kKernels);
    shape.stride_y = pick(random, std::array{1, 1, 2, 3});
    shape.stride_x = pick(random, std::array{1, 1, 2, 3});
    shape.padding_y = pick(random, std::array{0, 1, 1, 2, 3});
    shape.padding_x = pick(random, std::array{0, 1, 1, 2, 3});
    shape.dilation_y = pick(random, std::array{1, 1, 2, 3});
    shape.dilation_x = pick(random, std::array{1, 1, 2, 4});
  } while (shape.in_height + 2 * shape.padding_y <
               shape.dilation_y * (shape.kernel_height - 1) + 1 ||
           shape.in_width + 2 * shape.padding_x < shape.dilation_x * (shape.kernel_width - 1) + 1 ||
           products(shape) > 6e6);
  return shape;
}

/// Whole numbers so small that every sum is exact in float: results must then be equal, not close.
inline std::vector<float> whole_numbers(Random& random, std::size_t count) {
  std::vector<float> values(count);
  for (float& value : values) value = static_cast<float>(random.integer(-4, 4));
  return values;
}

}  // namespace imslam::nn::testing
