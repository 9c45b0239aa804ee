#pragma once

#include "slam/base/random.hpp"
#include "slam/nn/tape.hpp"

namespace imslam::nn {

/// Training: each number is set to 0 with the given probability, the others are divided by
/// (1 - probability), so that the mean stays. Inference: x itself. The draw depends on `random`
/// only.
template <typename S>
Var dropout(Tape<S>& tape, Var x, double probability, Random& random);

}  // namespace imslam::nn
