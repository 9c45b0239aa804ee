#pragma once

#include "slam/nn/tape.hpp"

namespace imslam::nn {

// All normalisations are one: numbers are cut into sets, each set gets mean 0 and variance 1.
//
//   h = (x - m) / sqrt(v + eps)    y = gain h + bias        m, v: mean and biased variance of the
//   set backward   dh = dy gain    dx = (dh - mean(dh) - h mean(dh h)) / sqrt(v + eps)
//              dgain = sum of dy h    dbias = sum of dy
//
//   layer_norm      one set per row                             x [...,C]
//   group_norm      per sample and group of channels            x [N,...,C], C divisible by groups
//   instance_norm   per sample and channel: group_norm, C groups
//   batch_norm      per channel over everything else
//
// All but the last treat each sample alone: safe at batch size 1. gain, bias [C] or none.

inline constexpr double kNormEpsilon = 1e-5;

template <typename S>
Var layer_norm(Tape<S>& tape, Var x, Var gain, Var bias);
template <typename S>
Var group_norm(Tape<S>& tape, Var x, Var gain, Var bias, int groups);
template <typename S>
Var instance_norm(Tape<S>& tape, Var x, Var gain, Var bias);

/// With the statistics of this batch, which are returned for running averages; constants.
struct BatchNormResult {
  Var y;
  Var mean;      ///< [C]
  Var variance;  ///< [C], biased
};
template <typename S>
BatchNormResult batch_norm(Tape<S>& tape, Var x, Var gain, Var bias);

/// Each row divided by its length: y = x / sqrt(|x|^2 + 1e-12).
///   backward   dx = (dy - y <y, dy>) / sqrt(|x|^2 + 1e-12)
template <typename S>
Var l2_normalise(Tape<S>& tape, Var x);

}  // namespace imslam::nn
