#pragma once

#include "slam/base/random.hpp"
#include "slam/nn/parameter.hpp"

namespace imslam::nn {

// Fill a weight whose last axis is the output, all others the input: fan_in = rows(), of a
// convolution Ky Kx Cin; fan_out = size / Cin.

/// Normal with variance 2 / fan_in: keeps the size of signals through ReLUs. He et al. 2015.
template <typename S>
void initialise_kaiming(Parameter<S>& weight, Random& random);

/// Uniform with variance 2 / (fan_in + fan_out): for tanh, sigmoid, attention. Glorot, Bengio 2010.
template <typename S>
void initialise_xavier(Parameter<S>& weight, Random& random);

/// Uniform in [-bound, bound).
template <typename S>
void initialise_uniform(Parameter<S>& weight, double bound, Random& random);

/// A constant, e.g. 0 for a head whose untrained output must change nothing.
template <typename S>
void initialise_constant(Parameter<S>& weight, double value);

}  // namespace imslam::nn
