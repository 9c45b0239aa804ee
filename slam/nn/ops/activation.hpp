#pragma once

#include "slam/nn/tape.hpp"

namespace imslam::nn {

// Number by number; y has the shape of x. Where a function has a kink its slope there is that of
// the left side (relu: 0 at 0).

template <typename S>
Var relu(Tape<S>& tape, Var x);  ///< max(x, 0)
template <typename S>
Var add_relu(Tape<S>& tape, Var a, Var b);  ///< max(a + b, 0) of one shape, in one pass
template <typename S>
Var leaky_relu(Tape<S>& tape, Var x, double slope = 0.1);  ///< x > 0 ? x : slope x
template <typename S>
Var elu(Tape<S>& tape, Var x);  ///< x > 0 ? x : e^x - 1
template <typename S>
Var gelu(Tape<S>& tape, Var x);  ///< x/2 (1 + tanh(sqrt(2/pi) (x + 0.044715 x^3)))
template <typename S>
Var silu(Tape<S>& tape, Var x);  ///< x sigmoid(x)
template <typename S>
Var tanh(Tape<S>& tape, Var x);
template <typename S>
Var sigmoid(Tape<S>& tape, Var x);  ///< 1 / (1 + e^-x)
template <typename S>
Var softplus(Tape<S>& tape, Var x);  ///< log(1 + e^x)

}  // namespace imslam::nn
