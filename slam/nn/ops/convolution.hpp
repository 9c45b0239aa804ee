#pragma once

#include "slam/nn/kernels/convolution.hpp"
#include "slam/nn/tape.hpp"

namespace imslam::nn {

/// How the kernel moves over the image; the same along both axes unless set apart.
struct ConvolutionOptions {
  int stride_y = 1;
  int stride_x = 1;
  int padding_y = 0;  ///< zeros on both sides
  int padding_x = 0;
  int dilation_y = 1;
  int dilation_x = 1;
  Activation activation = Activation::kNone;  ///< fused: costs nothing extra

  static ConvolutionOptions square(int stride, int padding, int dilation = 1);
};

/// y = activation(x * w + b)
///
///   x [N,H,W,Cin]    w [Ky,Kx,Cin,Cout]    b [Cout] or none    y [N,Ho,Wo,Cout]
///   Ho = (H + 2 padding_y - dilation_y (Ky - 1) - 1) / stride_y + 1
///
///   backward   dz = dy activation'(y)    dx = dz * w flipped and transposed    dw = x correlated
///   with
///              dz    db = sum of dz over pixels
template <typename S>
Var conv2d(Tape<S>& tape, Var x, Var w, Var b, const ConvolutionOptions& options);

/// The same along time: x [N,T,Cin]    w [K,Cin,Cout]    b [Cout] or none    y [N,To,Cout].
/// Uses the x half of the options. For a causal one pad in front (pad) and leave padding 0.
template <typename S>
Var conv1d(Tape<S>& tape, Var x, Var w, Var b, const ConvolutionOptions& options);

/// The transpose of conv2d as a linear map: it goes where the gradient of conv2d goes.
///
///   x [N,H,W,Cin]    w [Ky,Kx,Cout,Cin]    b [Cout] or none    y [N,Ho,Wo,Cout]
///   Ho = (H - 1) stride_y - 2 padding_y + dilation_y (Ky - 1) + 1
///
///   backward   dx = conv2d(dy, w)    dw = dy correlated with x    db = sum of dy over pixels
template <typename S>
Var transposed_conv2d(Tape<S>& tape, Var x, Var w, Var b, const ConvolutionOptions& options);

}  // namespace imslam::nn
