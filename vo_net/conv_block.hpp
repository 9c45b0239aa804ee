#pragma once

#include <string>

#include "slam/nn/layers/norm.hpp"

namespace imslam::vo {

/// y = activation(norm(x * w)): convolution with odd kernel that keeps the size (stride 1) or
/// halves it, rounding up (stride 2); output pixel (i, j) is centred on input pixel stride (i, j).
///
/// fold() makes it one convolution with fused activation for inference, with the same numbers.
template <typename S>
struct ConvBlock {
  struct Geometry {
    int kernel = 3;
    int stride = 1;
    int dilation = 1;
    nn::Activation activation = nn::Activation::kRelu;
  };

  ConvBlock() = default;
  ConvBlock(int inputs, int outputs, const Geometry& geometry, Random& random);

  nn::Var forward(nn::Tape<S>& tape, nn::Var x);  ///< [N,H,W,inputs] -> [N,Ho,Wo,outputs]
  void collect(nn::ParameterList<S>& list, const std::string& prefix);
  void fold();

  nn::Conv2d<S> conv;  ///< its bias stays 0 until the norm is folded into it
  nn::BatchNorm<S> norm;
  nn::Activation activation = nn::Activation::kRelu;
  bool folded = false;
};

/// y = relu(x + block(x))
template <typename S>
struct ResidualBlock {
  ResidualBlock() = default;
  ResidualBlock(int channels, int dilation, Random& random)
      : block(channels, channels, {3, 1, dilation, nn::Activation::kNone}, random) {}

  nn::Var forward(nn::Tape<S>& tape, nn::Var x);
  void collect(nn::ParameterList<S>& list, const std::string& prefix) {
    block.collect(list, prefix);
  }

  ConvBlock<S> block;
};

}  // namespace imslam::vo
