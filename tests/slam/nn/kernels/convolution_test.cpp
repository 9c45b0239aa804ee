#include "slam/nn/kernels/convolution.hpp"

#include <gtest/gtest.h>

#include "slam/base/error.hpp"

namespace imslam::nn {
namespace {

TEST(Convolution, RejectsAKernelLargerThanThePaddedInput) {
  ConvolutionShape shape;
  shape.in_width = 4;
  shape.kernel_width = 5;
  EXPECT_THROW(shape.validate(), ContractError);
  shape.padding_x = 1;
  EXPECT_NO_THROW(shape.validate());
}

}  // namespace
}  // namespace imslam::nn
