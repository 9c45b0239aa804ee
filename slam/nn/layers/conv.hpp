#pragma once

#include <string>

#include "slam/nn/layers/initialise.hpp"
#include "slam/nn/ops/convolution.hpp"

namespace imslam::nn {

/// y = activation(x * w + b) on images [N,H,W,C]; see conv2d().
template <typename S>
struct Conv2d {
  Conv2d() = default;
  Conv2d(int inputs, int outputs, int kernel, const ConvolutionOptions& how, Random& random)
      : options(how), weight({kernel, kernel, inputs, outputs}), bias(Shape{outputs}) {
    initialise_kaiming(weight, random);
  }

  Var forward(Tape<S>& tape, Var x) const {
    return conv2d(tape, x, tape.parameter(weight), tape.parameter(bias), options);
  }

  void collect(ParameterList<S>& list, const std::string& prefix) {
    list.add(prefix + "weight", weight);
    list.add(prefix + "bias", bias);
  }

  ConvolutionOptions options;
  Parameter<S> weight;  ///< [kernel, kernel, inputs, outputs]
  Parameter<S> bias;    ///< [outputs]
};

/// The same on sequences [N,T,C]; see conv1d().
template <typename S>
struct Conv1d {
  Conv1d() = default;
  Conv1d(int inputs, int outputs, int kernel, const ConvolutionOptions& how, Random& random)
      : options(how), weight({kernel, inputs, outputs}), bias(Shape{outputs}) {
    initialise_kaiming(weight, random);
  }

  Var forward(Tape<S>& tape, Var x) const {
    return conv1d(tape, x, tape.parameter(weight), tape.parameter(bias), options);
  }

  void collect(ParameterList<S>& list, const std::string& prefix) {
    list.add(prefix + "weight", weight);
    list.add(prefix + "bias", bias);
  }

  ConvolutionOptions options;
  Parameter<S> weight;  ///< [kernel, inputs, outputs]
  Parameter<S> bias;    ///< [outputs]
};

}  // namespace imslam::nn
