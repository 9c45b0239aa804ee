#pragma once

#include "slam/nn/tape.hpp"

namespace imslam::nn {

// Over the channels (last axis) of each row.
//
//   softmax       y_i = e^{x_i} / sum_j e^{x_j}           dx = y (dy - <dy, y>)
//   log_softmax   y_i = x_i - log sum_j e^{x_j}           dx = dy - e^y sum dy
//
// mask (optional, constant): 0 takes a channel out of the sum; its shape is that of the last axes
// of x and it is repeated over the others. softmax gives 0 there, log_softmax
// kMaskedLogProbability; no gradient flows. A row without any channel left is 0 (or
// kMaskedLogProbability) throughout.

inline constexpr double kMaskedLogProbability = -1e30;

template <typename S>
Var softmax(Tape<S>& tape, Var x, Var mask = {});
template <typename S>
Var log_softmax(Tape<S>& tape, Var x, Var mask = {});

/// How sure a softmax is, in one pass over its row.
///
///   x [...,K]    y [...,2] = [largest p, entropy H],   p = softmax(x),   H = -sum_i p_i log p_i
///   dx_j += dy_0 p_b ([j = b] - p_j) - dy_1 p_j (log p_j + H),   b the first of the largest
template <typename S>
Var softmax_summary(Tape<S>& tape, Var x);

}  // namespace imslam::nn
