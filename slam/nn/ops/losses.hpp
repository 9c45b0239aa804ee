#pragma once

#include <cstdint>
#include <vector>

#include "slam/nn/tape.hpp"

namespace imslam::nn {

// Losses per number or per row, not yet averaged: mean() or masked_mean() (reduce.hpp) comes after.

template <typename S>
Var absolute_error(Tape<S>& tape, Var x, Var target);  ///< |x - target|
template <typename S>
Var squared_error(Tape<S>& tape, Var x, Var target);  ///< (x - target)^2

/// r = x - target:   |r| <= delta:  r^2 / 2    else:  delta (|r| - delta / 2)
template <typename S>
Var huber(Tape<S>& tape, Var x, Var target, double delta);

/// -log softmax(logits)[class]      logits [...,C]    classes: one per row    y [...]
template <typename S>
Var cross_entropy(Tape<S>& tape, Var logits, const std::vector<std::int32_t>& classes);
/// -sum_i target_i log softmax(logits)_i     targets [...,C], constant    y [...]
template <typename S>
Var soft_cross_entropy(Tape<S>& tape, Var logits, Var targets);

/// -t log sigmoid(x) - (1 - t) log(1 - sigmoid(x)) = max(x, 0) - x t + log(1 + e^-|x|)
template <typename S>
Var binary_cross_entropy_with_logits(Tape<S>& tape, Var logits, Var targets);

// Negative log-likelihoods of a residual r = prediction - truth with a predicted scale s = log
// sigma. Bound s from below (clamp): where r is exactly 0, s runs away to -infinity.

/// s + r^2 e^{-2s} / 2 + log(2 pi) / 2       r, s: same shape
template <typename S>
Var gaussian_nll(Tape<S>& tape, Var residual, Var log_sigma);

/// s + (nu + 1)/2 log(1 + (r e^-s)^2 / nu) + log(sqrt(nu pi) Gamma(nu/2) / Gamma((nu + 1)/2))
template <typename S>
Var student_t_nll(Tape<S>& tape, Var residual, Var log_sigma, double nu);

/// Two dimensions, scale matrix L L^T with L = [e^{s_0} 0; l e^{s_1}]:
///   s_0 + s_1 + (nu + 2)/2 log(1 + |L^-1 r|^2 / nu) + log(nu pi Gamma(nu/2) / Gamma((nu + 2)/2))
///   residual [...,2]    factor [...,3] = (s_0, s_1, l)    y [...]
template <typename S>
Var student_t_nll_2d(Tape<S>& tape, Var residual, Var factor, double nu);

}  // namespace imslam::nn
