#pragma once

#include "slam/nn/tape.hpp"

namespace imslam::nn {

// x [N,H,W,C] -> y [N,Ho,Wo,C] with Ho = (H - size) / stride + 1: windows that do not fit are left
// out.
//
//   max_pool       dx = dy at the first largest of each window and channel
//   average_pool   dx = dy / size^2 over the window

template <typename S>
Var max_pool(Tape<S>& tape, Var x, int size, int stride);
template <typename S>
Var average_pool(Tape<S>& tape, Var x, int size, int stride);

// Over all pixels: x [N,H,W,C] -> y [N,C].

template <typename S>
Var global_max_pool(Tape<S>& tape, Var x);
template <typename S>
Var global_average_pool(Tape<S>& tape, Var x);

}  // namespace imslam::nn
