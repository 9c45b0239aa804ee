#include "slam/nn/ops/convolution.hpp"

#include <algorithm>
#include <limits>

#include "slam/nn/ops/elementwise.hpp"
#include "slam/nn/ops/layout.hpp"
#include "slam/nn/ops/plain_convolution.hpp"

namespace imslam::nn {
namespace {

/// x [N,H,W,Cin], w [Ky,Kx,Cin,Cout] -> the sizes that the kernels take.
ConvolutionShape kernel_shape(const Shape& x, const Shape& w, const ConvolutionOptions& options) {
  expects_shapes(x.rank() == 4 && w.rank() == 4 && x[3] == w[2],
                 "convolution: x [N,H,W,Cin] and w [Ky,Kx,Cin,Cout]", x, w);
  expects_shapes(std::max(x.size(), w.size()) <= std::numeric_limits<int>::max(),
                 "convolution: sizes below 2^31", x, w);
  ConvolutionShape s;
  s.batch = static_cast<int>(x[0]);
  s.in_height = static_cast<int>(x[1]);
  s.in_width = static_cast<int>(x[2]);
  s.in_channels = static_cast<int>(x[3]);
  s.kernel_height = static_cast<int>(w[0]);
  s.kernel_width = static_cast<int>(w[1]);
  s.out_channels = static_cast<int>(w[3]);
  s.stride_y = options.stride_y;
  s.stride_x = options.stride_x;
  s.padding_y = options.padding_y;
  s.padding_x = options.padding_x;
  s.dilation_y = options.dilation_y;
  s.dilation_x = options.dilation_x;
  s.validate();
  return s;
}

Shape output_shape(const ConvolutionShape& s) {
  return {s.batch, s.out_height(), s.out_width(), s.out_channels};
}

/// What a fused activation multiplies numbers below zero with.
double slope_below_zero(Activation activation) {
  return activation == Activation::kLeakyRelu ? double(kLeakySlope) : 0.0;
}

template <typename S>
void conv_backward(
    Tape<S>& t, const ConvolutionShape& s, Activation activation, Var x, Var w, Var b, Var y) {
  const Index size = t.shape(y).size();
  Scratch<S> scratch(t);
  const S* dz = t.gradient_data(y);
  if (activation != Activation::kNone) {
    S* const masked = scratch.template array<S>(size);
    through_relu(size, t.data(y), dz, S(slope_below_zero(activation)),
                 [masked](Index i, S v) { masked[i] = v; });
    dz = masked;
  }
  t.accumulate_overwriting(
      x, [&](S* dx) { convolution_backward_data(s, t.data(w), dz, dx, t.workspace()); });
  if (!t.wants_gradient(w) && !t.wants_gradient(b)) return;
  S* const db = scratch.template array<S>(s.out_channels);
  S* const dw = scratch.template array<S>(static_cast<Index>(s.weight_size()));
  convolution_backward_weights(s, t.data(x), dz, dw, db, t.workspace());
  t.accumulate(w, [&](ArrayMap<S> dW) { dW += ArrayMap<S>(dw, dW.size()); });
  t.accumulate(b, [&](ArrayMap<S> dB) { dB += ArrayMap<S>(db, dB.size()); });
}

template <typename S>
void expect_bias(const Tape<S>& tape, Var b, Index channels) {
  if (b) expects_shape(tape.shape(b) == Shape{channels}, "convolution: bias [Cout]", tape.shape(b));
}

}  // namespace

ConvolutionOptions ConvolutionOptions::square(int stride, int padding, int dilation) {
  ConvolutionOptions options;
  options.stride_y = options.stride_x = stride;
  options.padding_y = options.padding_x = padding;
  options.dilation_y = options.dilation_x = dilation;
  return options;
}

template <typename S>
Var conv2d(Tape<S>& tape, Var x, Var w, Var b, const ConvolutionOptions& options) {
  const ConvolutionShape s = kernel_shape(tape.shape(x), tape.shape(w), options);
  expect_bias(tape, b, s.out_channels);
  const Var y = tape.make(output_shape(s));
  convolution_forward(s, tape.data(x), tape.data(w), b ? tape.data(b) : nullptr, options.activation,
                      tape.data(y), tape.workspace());
  const Activation activation = options.activation;
  return tape.record(y, {x, w, b},
                     [=](Tape<S>& t) { conv_backward(t, s, activation, x, w, b, y); });
}

template <typename S>
Var conv1d(Tape<S>& tape, Var x, Var w, Var b, const ConvolutionOptions& options) {
  const Shape of_x = tape.shape(x);
  const Shape of_w = tape.shape(w);
  expects_shapes(of_x.rank() == 3 && of_w.rank() == 3, "conv1d: x [N,T,Cin] and w [K,Cin,Cout]",
                 of_x, of_w);
  ConvolutionOptions flat = options;
  flat.stride_y = flat.dilation_y = 1;
  flat.padding_y = 0;
  const Var image = reshape(tape, x, {of_x[0], 1, of_x[1], of_x[2]});
  const Var kernel = reshape(tape, w, {1, of_w[0], of_w[1], of_w[2]});
  const Var y = conv2d(tape, image, kernel, b, flat);
  const Shape of_y = tape.shape(y);
  return reshape(tape, y, {of_y[0], of_y[2], of_y[3]});
}

template <typename S>
Var transposed_conv2d(Tape<S>& tape, Var x, Var w, Var b, const ConvolutionOptions& options) {
  const Shape of_x = tape.shape(x);
  const Shape of_w = tape.shape(w);
  expects_shapes(of_x.rank() == 4 && of_w.rank() == 4 && of_x[3] == of_w[3],
                 "transposed_conv2d: x [N,H,W,Cin] and w [Ky,Kx,Cout,Cin]", of_x, of_w);
  expects(options.activation == Activation::kNone, "transposed_conv2d: no fused activation");
  const Index height = (of_x[1] - 1) * options.stride_y - 2 * options.padding_y +
                       options.dilation_y * (of_w[0] - 1) + 1;
  const Index width = (of_x[2] - 1) * options.stride_x - 2 * options.padding_x +
                      options.dilation_x * (of_w[1] - 1) + 1;
  // The convolution whose transpose this is: it reads y and writes x.
  const Shape of_y{of_x[0], height, width, of_w[2]};
  const ConvolutionShape s = kernel_shape(of_y, of_w, options);
  expect_bias(tape, b, of_w[2]);
  const Var y = tape.make(of_y);
  convolution_backward_data(s, tape.data(w), tape.data(x), tape.data(y), tape.workspace());
  if (b) tape.matrix(y).rowwise() += tape.matrix(b).row(0);
  return tape.record(y, {x, w, b}, [=](Tape<S>& t) {
    const S* const none = nullptr;
    const S* const dy = t.gradient_data(y);
    t.accumulate_overwriting(x, [&](S* dx) {
      convolution_forward(s, dy, t.data(w), none, Activation::kNone, dx, t.workspace());
    });
    t.accumulate_overwriting(w, [&](S* dw) {
      S* const no_bias = nullptr;
      convolution_backward_weights(s, dy, t.data(x), dw, no_bias, t.workspace());
    });
    if (t.wants_gradient(b)) {
      t.gradient_matrix(b) += t.gradient_matrix(y).colwise().sum();
    }
  });
}

#define INSTANTIATE(S)                                                     \
  template Var conv2d(Tape<S>&, Var, Var, Var, const ConvolutionOptions&); \
  template Var conv1d(Tape<S>&, Var, Var, Var, const ConvolutionOptions&); \
  template Var transposed_conv2d(Tape<S>&, Var, Var, Var, const ConvolutionOptions&);
IMSLAM_NN_FOR_EACH_SCALAR(INSTANTIATE)

}  // namespace imslam::nn
