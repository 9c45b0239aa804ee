#pragma once

#include "slam/nn/tape.hpp"

namespace imslam::nn {

// y = a op b, number by number, with the shapes broadcast (see broadcast.hpp). The gradient of an
// operand that was repeated is the sum over its repetitions.
//
//   add        da = dy           db = dy
//   subtract   da = dy           db = -dy
//   multiply   da = dy b         db = dy a
//   divide     da = dy / b       db = -dy y / b

template <typename S>
Var add(Tape<S>& tape, Var a, Var b);
template <typename S>
Var subtract(Tape<S>& tape, Var a, Var b);
template <typename S>
Var multiply(Tape<S>& tape, Var a, Var b);
template <typename S>
Var divide(Tape<S>& tape, Var a, Var b);

}  // namespace imslam::nn
