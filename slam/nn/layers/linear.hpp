#pragma once

#include <string>

#include "slam/nn/layers/initialise.hpp"
#include "slam/nn/ops/product.hpp"

namespace imslam::nn {

/// y = activation(x W + b) on the last axis; see linear().
template <typename S>
struct Linear {
  Linear() = default;
  Linear(int inputs, int outputs, Random& random)
      : weight({inputs, outputs}), bias(Shape{outputs}) {
    initialise_kaiming(weight, random);
  }

  Var forward(Tape<S>& tape, Var x, Activation activation = Activation::kNone) const {
    return linear(tape, x, tape.parameter(weight), tape.parameter(bias), activation);
  }

  void collect(ParameterList<S>& list, const std::string& prefix) {
    list.add(prefix + "weight", weight);
    list.add(prefix + "bias", bias);
  }

  Parameter<S> weight;  ///< [inputs, outputs]
  Parameter<S> bias;    ///< [outputs]
};

}  // namespace imslam::nn
