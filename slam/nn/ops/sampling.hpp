#pragma once

#include "slam/nn/tape.hpp"

namespace imslam::nn {

/// What lies beyond the image.
enum class Border {
  kClamp,  ///< the nearest pixel; no gradient to a clamped coordinate
  kZero,   ///< zeros
};

/// Reads an image between its pixels.
///
///   image [N,H,W,C]    points [N,P,2] (x, y) in pixels, pixel centres at whole numbers    y
///   [N,P,C] y = (1-u)(1-v) I00 + u (1-v) I10 + (1-u) v I01 + u v I11       u, v: parts after the
///   point backward   dI.. += weight dy    dx = <dy, (1-v)(I10 - I00) + v (I11 - I01)>    dy
///   likewise
///
/// A point that is not finite reads 0 and sends nothing back.
template <typename S>
Var bilinear_sample(Tape<S>& tape, Var image, Var points, Border border);

/// y[n, i, j] = image[n, i + flow_y, j + flow_x]: brings the image that a flow field points into
/// onto the grid of the field.   image [N,H,W,C]    flow [N,h,w,2] (x, y) [pixels]    y [N,h,w,C]
template <typename S>
Var warp(Tape<S>& tape, Var image, Var flow, Border border);

}  // namespace imslam::nn
