#pragma once

#include "slam/nn/tape.hpp"

namespace imslam::nn {

// Number by number; y has the shape of x.

template <typename S>
Var exp(Tape<S>& tape, Var x);
template <typename S>
Var log(Tape<S>& tape, Var x);  ///< x > 0 is the caller's business
template <typename S>
Var sqrt(Tape<S>& tape, Var x);  ///< x > 0: the slope at 0 is infinite
template <typename S>
Var abs(Tape<S>& tape, Var x);  ///< slope at 0: 0
template <typename S>
Var square(Tape<S>& tape, Var x);
template <typename S>
Var clamp(Tape<S>& tape, Var x, double low, double high);  ///< slope 0 outside and at the bounds
template <typename S>
Var scale(Tape<S>& tape, Var x, double factor);  ///< factor x
template <typename S>
Var shift(Tape<S>& tape, Var x, double offset);  ///< x + offset
template <typename S>
Var stop_gradient(Tape<S>& tape, Var x);  ///< x, as a constant

}  // namespace imslam::nn
