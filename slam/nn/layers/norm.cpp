#include "slam/nn/layers/norm.hpp"

#include "slam/nn/ops/arithmetic.hpp"
#include "slam/nn/ops/pointwise.hpp"

namespace imslam::nn {

template <typename S>
BatchNorm<S>::BatchNorm(int channels)
    : Affine<S>(channels),
      running_mean(Shape{channels}, false),
      running_variance(Shape{channels}, false) {
  initialise_constant(running_variance, 1.0);
}

template <typename S>
Var BatchNorm<S>::forward(Tape<S>& tape, Var x) {
  const Var g = tape.parameter(this->gain);
  const Var b = tape.parameter(this->bias);
  if (tape.training() && !frozen) {
    const BatchNormResult batch = batch_norm(tape, x, g, b);
    const double n = static_cast<double>(tape.shape(x).rows());
    tape.observe(running_mean, batch.mean, rate);
    tape.observe(running_variance, scale(tape, batch.variance, n > 1.0 ? n / (n - 1.0) : 1.0),
                 rate);
    return batch.y;
  }
  const Var variance = shift(tape, tape.parameter(running_variance), kNormEpsilon);
  const Var slope = divide(tape, g, sqrt(tape, variance));
  const Var centred = subtract(tape, x, tape.parameter(running_mean));
  return add(tape, multiply(tape, centred, slope), b);
}

template <typename S>
void BatchNorm<S>::collect(ParameterList<S>& list, const std::string& prefix) {
  Affine<S>::collect(list, prefix);
  list.add(prefix + "running_mean", running_mean);
  list.add(prefix + "running_variance", running_variance);
}

template <typename S>
void fold(const BatchNorm<S>& norm, Conv2d<S>& conv) {
  const Index channels = norm.gain.value.size();
  expects_shapes(conv.bias.value.size() == channels, "fold: as many channels as the convolution",
                 conv.bias.value.shape(), norm.gain.value.shape());
  expects(conv.options.activation == Activation::kNone,
          "fold: an activation stands between the convolution and the norm");
  const Eigen::Array<S, Eigen::Dynamic, 1> slope =
      norm.gain.value.array() / (norm.running_variance.value.array() + S(kNormEpsilon)).sqrt();
  conv.weight.value.matrix().array().rowwise() *= slope.transpose();
  conv.bias.value.array() =
      (conv.bias.value.array() - norm.running_mean.value.array()) * slope + norm.bias.value.array();
}

#define INSTANTIATE(S)          \
  template struct BatchNorm<S>; \
  template void fold(const BatchNorm<S>&, Conv2d<S>&);
IMSLAM_NN_FOR_EACH_SCALAR(INSTANTIATE)

}  // namespace imslam::nn
