#pragma once

#include "slam/nn/ops/correlation.hpp"

namespace imslam::vo {

/// What one level of the pyramid says about the displacements of N x P query points.
///
/// Number k of the logits stands for the displacement   origin + stride (window.x(k), window.y(k))
/// and the level's own answer is   displacement = origin + stride softargmax(logits).
struct LevelMatch {
  int stride = 1;        ///< [px] of a cell
  nn::Window window;     ///< [cells]
  nn::Var logits;        ///< [N,P,K]
  nn::Var origin;        ///< [N,P,2] (x, y) [px], a constant
  nn::Var displacement;  ///< [N,P,2] (x, y) [px]
};

/// The expected cell under softmax(logits), within `radius` cells around the largest logit only:
/// the mean over all of a window lies between its modes, where nothing is.
///
///   logits [...,K]    y [...,2] (x, y) [cells]    d cell / d logits as of the softmax; the choice
///   of the neighbourhood has no derivative
template <typename S>
nn::Var local_soft_argmax(nn::Tape<S>& tape,
                          nn::Var logits,
                          const nn::Window& window,
                          int radius = 1);

}  // namespace imslam::vo
