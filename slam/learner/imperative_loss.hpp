#pragma once

#include "slam/learner/gradient_strategy.hpp"
#include "slam/nn/tape.hpp"

namespace imslam::learner {

/// What the network says, for the lower level.
template <typename S>
Vector numbers_of(const nn::Tape<S>& tape, nn::Var z);

/// U as one number on the tape that went through the solver; back:  dz += dU/dz dU. A refused
/// gradient is a constant 0.
template <typename S>
nn::Var imperative_loss(nn::Tape<S>& tape, nn::Var z, const UpperGradient& upper);

}  // namespace imslam::learner
