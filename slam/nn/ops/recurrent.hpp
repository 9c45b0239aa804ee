#pragma once

#include "slam/nn/tape.hpp"

namespace imslam::nn {

/// Gated recurrent unit over a whole sequence, causal, one step after the other.
///
///   [a_r a_z a_n] = x_t Wx + bx    (for all t at once, by linear())
///   [c_r c_z c_n] = h_{t-1} Wh + bh
///   r = sigmoid(a_r + c_r)    z = sigmoid(a_z + c_z)    n = tanh(a_n + r c_n)
///   h_t = (1 - z) n + z h_{t-1}
///
///   backward, t from the last to the first, dh = dy_t + what comes from t + 1
///   dn = dh (1 - z) (1 - n^2)    dz = dh (h_{t-1} - n) z (1 - z)    dr = dn c_n r (1 - r)
///   da = [dr dz dn]    dc = [dr dz dn r]    dWh += h_{t-1}^T dc    dbh += 1^T dc
///   dh_{t-1} = dh z + dc Wh^T
///
///   a [N,T,3H]    h0 [N,H]    wh [H,3H]    bh [3H]    y [N,T,H] = h_1..h_T
///
/// Cho et al. 2014, with the reset gate after the product. The state to go on with is
/// last_state(y): a sequence cut in two gives the same numbers as a whole one.
template <typename S>
Var gru_scan(Tape<S>& tape, Var a, Var h0, Var wh, Var bh);

/// The whole of it: x [N,T,I], wx [I,3H], bx [3H].
template <typename S>
Var gru(Tape<S>& tape, Var x, Var h0, Var wx, Var bx, Var wh, Var bh);

/// One step: x [N,I], h [N,H] -> [N,H].
template <typename S>
Var gru_cell(Tape<S>& tape, Var x, Var h, Var wx, Var bx, Var wh, Var bh);

/// y [N,T,H] -> h_T [N,H].
template <typename S>
Var last_state(Tape<S>& tape, Var y);

}  // namespace imslam::nn
