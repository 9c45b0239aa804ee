#include "vo_net/conv_block.hpp"

#include "slam/nn/ops/activation.hpp"

namespace imslam::vo {
namespace {

// Samples are observed one by one, each with statistics of its own scene: a long memory is needed.
constexpr double kStatisticsRate = 0.01;

}  // namespace

template <typename S>
ConvBlock<S>::ConvBlock(int inputs, int outputs, const Geometry& geometry, Random& random)
    : conv(inputs,
           outputs,
           geometry.kernel,
           nn::ConvolutionOptions::square(
               geometry.stride, geometry.dilation * (geometry.kernel / 2), geometry.dilation),
           random),
      norm(outputs),
      activation(geometry.activation) {
  conv.bias.trainable = false;  // the norm takes away whatever it adds
  norm.rate = kStatisticsRate;
}

template <typename S>
nn::Var ConvBlock<S>::forward(nn::Tape<S>& tape, nn::Var x) {
  const nn::Var z = conv.forward(tape, x);
  if (folded) return z;
  const nn::Var y = norm.forward(tape, z);
  return activation == nn::Activation::kRelu ? relu(tape, y) : y;
}

template <typename S>
void ConvBlock<S>::collect(nn::ParameterList<S>& list, const std::string& prefix) {
  expects(!folded, "ConvBlock::collect: the norm is folded away, its weights are no more");
  conv.collect(list, prefix + "conv.");
  norm.collect(list, prefix + "norm.");
}

template <typename S>
void ConvBlock<S>::fold() {
  if (folded) return;
  nn::fold(norm, conv);
  conv.options.activation = activation;
  folded = true;
}

template <typename S>
nn::Var ResidualBlock<S>::forward(nn::Tape<S>& tape, nn::Var x) {
  return add_relu(tape, x, block.forward(tape, x));
}

template struct ConvBlock<float>;
template struct ConvBlock<double>;
template struct ResidualBlock<float>;
template struct ResidualBlock<double>;

}  // namespace imslam::vo
