#pragma once

#include "slam/nn/tape.hpp"

namespace imslam::nn {

/// Scaled dot-product attention with several heads: channels are cut into heads, each looks alone.
///
///   per sample and head    Y = softmax(Q K^T / sqrt(d)) V    d: query channels per head
///
///   q [N,Tq,D]    k [N,Tk,D]    v [N,Tk,Dv]    y [N,Tq,Dv]    D, Dv divisible by heads
///   mask [Tq,Tk] or none (constant): 0 where a query must not look
template <typename S>
Var attention(Tape<S>& tape, Var q, Var k, Var v, int heads, Var mask = {});

/// 1 where key <= query: attention that does not see the future. [steps,steps]
template <typename S>
Var causal_mask(Tape<S>& tape, Index steps);

}  // namespace imslam::nn
