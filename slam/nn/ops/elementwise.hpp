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

/// d_i * (y_i > 0 ? 1 : below) for all i: the way back through a (leaky) ReLU, told from its
/// output. A plain loop because Eigen's select branches, which costs ten times as much at random
/// signs.
template <typename S, typename Store>
void through_relu(Index count, const S* y, const S* dy, S below, const Store& store) {
  for (Index i = 0; i < count; ++i) {
    const S slope = y[i] > S(0) ? S(1) : below;
    store(i, slope * dy[i]);
  }
}

}  // namespace imslam::nn
