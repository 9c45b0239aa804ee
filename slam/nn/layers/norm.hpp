#pragma once

#include <string>

#include "slam/nn/layers/conv.hpp"
#include "slam/nn/ops/normalise.hpp"

namespace imslam::nn {

/// Gain and bias per channel, 1 and 0 at the start, for layer_norm, group_norm and instance_norm.
template <typename S>
struct Affine {
  Affine() = default;
  explicit Affine(int channels) : gain(Shape{channels}), bias(Shape{channels}) {
    initialise_constant(gain, 1.0);
  }

  void collect(ParameterList<S>& list, const std::string& prefix) {
    list.add(prefix + "gain", gain);
    list.add(prefix + "bias", bias);
  }

  Parameter<S> gain;  ///< [channels]
  Parameter<S> bias;  ///< [channels]
};

/// Each row by itself.
template <typename S>
struct LayerNorm : Affine<S> {
  using Affine<S>::Affine;
  Var forward(Tape<S>& tape, Var x) const {
    return layer_norm(tape, x, tape.parameter(this->gain), tape.parameter(this->bias));
  }
};

/// Each sample and group of channels by itself. As many groups as channels: instance norm.
template <typename S>
struct GroupNorm : Affine<S> {
  GroupNorm() = default;
  GroupNorm(int channels, int number_of_groups) : Affine<S>(channels), groups(number_of_groups) {}
  Var forward(Tape<S>& tape, Var x) const {
    return group_norm(tape, x, tape.parameter(this->gain), tape.parameter(this->bias), groups);
  }
  int groups = 1;
};

/// Statistics of the batch while training, running averages of them otherwise.
///
///   running <- (1 - rate) running + rate batch      by Tape::apply_observations, with the unbiased
///   variance
///
/// With `frozen` the running statistics are used in training too; then, or at the end, the layer is
/// one affine map per channel and folds into the convolution before it.
template <typename S>
struct BatchNorm : Affine<S> {
  BatchNorm() = default;
  explicit BatchNorm(int channels);

  Var forward(Tape<S>& tape, Var x);
  void collect(ParameterList<S>& list, const std::string& prefix);

  Parameter<S> running_mean;      ///< [channels], not trained
  Parameter<S> running_variance;  ///< [channels], not trained
  double rate = 0.1;
  bool frozen = false;
};

/// Changes `conv` (which must have no activation of its own) so that it gives what norm(conv(x))
/// gave with running statistics:   w' = w g    b' = (b - mean) g + bias    g = gain / sqrt(variance
/// + eps)
template <typename S>
void fold(const BatchNorm<S>& norm, Conv2d<S>& conv);

}  // namespace imslam::nn
