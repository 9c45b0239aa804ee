#pragma once

#include <functional>

#include "slam/nn/kernels/convolution.hpp"
#include "slam/nn/kernels/instruction_set.hpp"

namespace imslam::bench {

enum class Pass { kForward, kBackwardData, kBackwardWeights };

/// oneDNN's convolution of the same shape in the memory formats that it likes best; the arrays are
/// brought into them before. Empty where the build found no oneDNN.
std::function<void()> onednn_convolution(const nn::ConvolutionShape& shape, Pass pass);

/// Before the first convolution.
void limit_onednn(nn::InstructionSet set);
/// Of the calls that follow.
void set_onednn_threads(int threads);

}  // namespace imslam::bench
