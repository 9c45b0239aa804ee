#pragma once

#include <cmath>
#include <string>

#include "slam/nn/layers/initialise.hpp"
#include "slam/nn/ops/recurrent.hpp"

namespace imslam::nn {

/// Gated recurrent unit; the state goes in and comes out. See gru_scan().
template <typename S>
struct Gru {
  Gru() = default;
  Gru(int inputs, int hidden, Random& random)
      : weight_input({inputs, 3 * hidden}),
        weight_hidden({hidden, 3 * hidden}),
        bias_input(Shape{3 * hidden}),
        bias_hidden(Shape{3 * hidden}) {
    const double bound = 1.0 / std::sqrt(static_cast<double>(hidden));
    initialise_uniform(weight_input, bound, random);
    initialise_uniform(weight_hidden, bound, random);
  }

  int hidden() const { return static_cast<int>(weight_hidden.value.shape()[0]); }

  /// The state before anything was seen: zeros [samples, hidden].
  Var zero_state(Tape<S>& tape, Index samples) const {
    const Var h0 = tape.make({samples, hidden()});
    tape.array(h0) = S(0);
    return h0;
  }

  /// x [N,T,inputs], h0 [N,hidden] -> [N,T,hidden]; go on with last_state() of it.
  Var forward(Tape<S>& tape, Var x, Var h0) const {
    return gru(tape, x, h0, tape.parameter(weight_input), tape.parameter(bias_input),
               tape.parameter(weight_hidden), tape.parameter(bias_hidden));
  }

  void collect(ParameterList<S>& list, const std::string& prefix) {
    list.add(prefix + "weight_input", weight_input);
    list.add(prefix + "weight_hidden", weight_hidden);
    list.add(prefix + "bias_input", bias_input);
    list.add(prefix + "bias_hidden", bias_hidden);
  }

  Parameter<S> weight_input;   ///< [inputs, 3 hidden], gates r z n
  Parameter<S> weight_hidden;  ///< [hidden, 3 hidden]
  Parameter<S> bias_input;     ///< [3 hidden]
  Parameter<S> bias_hidden;    ///< [3 hidden]
};

}  // namespace imslam::nn
