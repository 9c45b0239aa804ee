#pragma once

#include "slam/nn/tape.hpp"

namespace imslam::nn {

/// Whether a reduced axis stays with size 1 (to broadcast against x) or goes.
enum class Axes { kDrop, kKeep };

// Over the named axes. Sums of floats are taken in double.
//   sum    dx = dy          mean   dx = dy / count          maximum   dx = dy at the first largest

template <typename S>
Var sum(Tape<S>& tape, Var x, std::initializer_list<int> axes, Axes reduced = Axes::kDrop);
template <typename S>
Var mean(Tape<S>& tape, Var x, std::initializer_list<int> axes, Axes reduced = Axes::kDrop);
template <typename S>
Var maximum(Tape<S>& tape, Var x, std::initializer_list<int> axes, Axes reduced = Axes::kDrop);

// Over everything: one number, shape [].

template <typename S>
Var sum(Tape<S>& tape, Var x);
template <typename S>
Var mean(Tape<S>& tape, Var x);

/// sum(mask x) / max(sum(mask), 1): the mean where mask is 1, and 0 (not NaN) if it is 1 nowhere.
/// mask: constant, same shape as x; weights between 0 and 1 are allowed.
template <typename S>
Var masked_mean(Tape<S>& tape, Var x, Var mask);

}  // namespace imslam::nn
