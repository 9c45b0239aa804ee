#pragma once

#include "slam/nn/tape.hpp"

namespace imslam::nn {

// x [N,H,W,C] -> y [N,height,width,C]. Pixel centres lie at half numbers and the two images cover
// the same area: x position = (i + 1/2) H / height - 1/2, clamped to the image.
//
//   nearest    the pixel that contains the position         dx[that pixel] += dy
//   bilinear   a weighted mean of the (up to) four around   dx[each] += weight dy
//
// For going up; going down by more than 2 skips pixels (pool first).

template <typename S>
Var resize_nearest(Tape<S>& tape, Var x, Index height, Index width);
template <typename S>
Var resize_bilinear(Tape<S>& tape, Var x, Index height, Index width);
template <typename S>
Var upsample2_nearest(Tape<S>& tape, Var x);  ///< to 2 H x 2 W
template <typename S>
Var upsample2_bilinear(Tape<S>& tape, Var x);  ///< to 2 H x 2 W

/// Bilinear with another convention: pixel i of y lies on x position i / 2, clamped to the image.
/// That undoes a convolution of stride 2 with padding, whose output pixel i is centred on input
/// pixel 2 i. x [N,ceil(height/2),ceil(width/2),C] -> y [N,height,width,C].
template <typename S>
Var upsample2_aligned(Tape<S>& tape, Var x, Index height, Index width);

/// y = fine + upsample2_aligned(x), in one pass. fine [N,height,width,C].
template <typename S>
Var add_upsampled2(Tape<S>& tape, Var fine, Var x);

}  // namespace imslam::nn
