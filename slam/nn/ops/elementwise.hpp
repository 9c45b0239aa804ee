#pragma once

#include "slam/nn/tape.hpp"

namespace imslam::nn {

/// One input, number by number. Both halves are statements on arrays of all numbers:
///
///   forward(X, Y)            Y = f(X)
///   backward(X, Y, dY, dX)   dX += dY * f'(X)
template <typename S, typename Forward, typename Backward>
Var elementwise(Tape<S>& tape, Var x, const Forward& forward, const Backward& backward) {
  const Var y = tape.make(tape.shape(x));
  forward(tape.array(x), tape.array(y));
  return tape.record(y, {x}, [x, y, backward](Tape<S>& t) {
    t.accumulate(x, [&](ArrayMap<S> dX) { backward(t.array(x), t.array(y), t.gradient(y), dX); });
  });
}

}  // namespace imslam::nn
