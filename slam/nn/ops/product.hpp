#pragma once

#include "slam/nn/kernels/convolution.hpp"
#include "slam/nn/tape.hpp"

namespace imslam::nn {

/// A matrix product as a convolution: the rows of X [rows, inner] are pixels of one line, W [inner,
/// columns] is the kernel.
ConvolutionShape product_shape(Index rows, Index inner, Index columns);

/// Y = activation(X W + b), row by row: a 1x1 convolution.
///
///   x [...,Cin]    w [Cin,Cout]    b [Cout] or none    y [...,Cout]
///   backward   dX = dZ W^T    dW = X^T dZ    db = 1^T dZ    with dZ = dY activation'(Y)
template <typename S>
Var linear(Tape<S>& tape, Var x, Var w, Var b, Activation activation = Activation::kNone);

/// Y_i = A_i B_i for each i of the leading axes.
///
///   a [...,M,K]    b [...,K,N] with the same leading axes, or [K,N] for all    y [...,M,N]
///   backward   dA = dY B^T    dB = A^T dY
template <typename S>
Var matmul(Tape<S>& tape, Var a, Var b);

/// The last two axes swapped: [...,M,N] -> [...,N,M].
template <typename S>
Var transpose(Tape<S>& tape, Var x);

}  // namespace imslam::nn
