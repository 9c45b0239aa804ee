#pragma once

#include <cstdint>
#include <vector>

#include "slam/nn/tape.hpp"

namespace imslam::nn {

/// Rows by number: y[k, ...] = x[indices[k], ...]; -1 gives a row of zeros.
///   x [R,...]    y [K,...]    backward   dx[indices[k]] += dy[k]
/// Throws ContractError on any other index outside of [0, R).
template <typename S>
Var gather(Tape<S>& tape, Var x, const std::vector<std::int32_t>& indices);

/// The transpose of gather: y[indices[k], ...] += x[k, ...]; rows with index -1 are dropped.
///   x [K,...]    y [rows,...]    backward   dx[k] = dy[indices[k]]
template <typename S>
Var scatter_add(Tape<S>& tape, Var x, const std::vector<std::int32_t>& indices, Index rows);

/// One channel of each row: y[r] = x[r, channels[r]], e.g. the log-probability of what was drawn.
///   x [...,C]    y [...] with as many numbers as x has rows
template <typename S>
Var pick(Tape<S>& tape, Var x, const std::vector<std::int32_t>& channels);

}  // namespace imslam::nn
