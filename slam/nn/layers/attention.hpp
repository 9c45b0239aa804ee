#pragma once

#include <string>

#include "slam/nn/layers/linear.hpp"
#include "slam/nn/ops/attention.hpp"

namespace imslam::nn {

/// Attention with learned maps in front and behind:
///   y = attention(x Wq, context Wk, context Wv) Wo      each with a bias
/// Self-attention when context is x.
template <typename S>
struct Attention {
  Attention() = default;
  Attention(int channels, int context_channels, int number_of_heads, Random& random)
      : query(channels, channels, random),
        key(context_channels, channels, random),
        value(context_channels, channels, random),
        output(channels, channels, random),
        heads(number_of_heads) {
    for (Linear<S>* layer : {&query, &key, &value, &output})
      initialise_xavier(layer->weight, random);
  }

  /// x [N,Tq,channels], context [N,Tk,context_channels], mask [Tq,Tk] or none -> [N,Tq,channels]
  Var forward(Tape<S>& tape, Var x, Var context, Var mask = {}) const {
    const Var y = attention(tape, query.forward(tape, x), key.forward(tape, context),
                            value.forward(tape, context), heads, mask);
    return output.forward(tape, y);
  }

  void collect(ParameterList<S>& list, const std::string& prefix) {
    query.collect(list, prefix + "query.");
    key.collect(list, prefix + "key.");
    value.collect(list, prefix + "value.");
    output.collect(list, prefix + "output.");
  }

  Linear<S> query;
  Linear<S> key;
  Linear<S> value;
  Linear<S> output;
  int heads = 1;
};

}  // namespace imslam::nn
