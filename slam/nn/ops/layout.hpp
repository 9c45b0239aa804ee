#pragma once

#include "slam/nn/tape.hpp"

namespace imslam::nn {

/// The same numbers in the same order under another shape; copies nothing.
template <typename S>
Var reshape(Tape<S>& tape, Var x, const Shape& shape);

/// Axes in another order: axis i of y is axis axes[i] of x. [N,H,W,C] with {0,3,1,2} -> [N,C,H,W].
template <typename S>
Var permute(Tape<S>& tape, Var x, std::initializer_list<int> axes);
template <typename S>
Var permute(Tape<S>& tape, Var x, const int* axes, int rank);

/// The part [start, start + length) of one axis.
template <typename S>
Var slice(Tape<S>& tape, Var x, int axis, Index start, Index length);

/// Zeros before and after along one axis. Causal convolutions pad time in front.
template <typename S>
Var pad(Tape<S>& tape, Var x, int axis, Index before, Index after);

/// One after the other along `axis`; all other sizes agree.
template <typename S>
Var concat(Tape<S>& tape, std::initializer_list<Var> parts, int axis);
template <typename S>
Var concat(Tape<S>& tape, const std::vector<Var>& parts, int axis);

/// A copy for each repetition of axes of size 1, as broadcasting would: [1,C] -> [N,C].
template <typename S>
Var expand(Tape<S>& tape, Var x, const Shape& shape);

}  // namespace imslam::nn
