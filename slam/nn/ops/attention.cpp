#include "slam/nn/ops/attention.hpp"

#include <cmath>

#include "slam/nn/ops/layout.hpp"
#include "slam/nn/ops/pointwise.hpp"
#include "slam/nn/ops/product.hpp"
#include "slam/nn/ops/softmax.hpp"

namespace imslam::nn {
namespace {

/// [N,T,D] -> [N,heads,T,D/heads]
template <typename S>
Var split_heads(Tape<S>& tape, Var x, int heads) {
  const Shape shape = tape.shape(x);
  expects_shape(shape.rank() == 3 && heads >= 1 && shape[2] % heads == 0,
                "attention: [N,T,D] with D divisible by the heads", shape);
  const Var cut = reshape(tape, x, {shape[0], shape[1], heads, shape[2] / heads});
  return permute(tape, cut, {0, 2, 1, 3});
}

}  // namespace

template <typename S>
Var attention(Tape<S>& tape, Var q, Var k, Var v, int heads, Var mask) {
  const Shape of_q = tape.shape(q);
  const Shape of_k = tape.shape(k);
  const Shape of_v = tape.shape(v);
  const Var queries = split_heads(tape, q, heads);
  const Var keys = split_heads(tape, k, heads);
  const Var values = split_heads(tape, v, heads);
  expects_shapes(of_q[0] == of_k[0] && of_q[2] == of_k[2], "attention: q [N,Tq,D], k [N,Tk,D]",
                 of_q, of_k);
  expects_shapes(of_k[1] == of_v[1], "attention: k [N,Tk,D], v [N,Tk,Dv]", of_k, of_v);
  const double width = static_cast<double>(of_q[2] / heads);
  const Var scores = matmul(tape, queries, transpose(tape, keys));
  const Var weights = softmax(tape, scale(tape, scores, 1.0 / std::sqrt(width)), mask);
  const Var heads_apart = permute(tape, matmul(tape, weights, values), {0, 2, 1, 3});
  return reshape(tape, heads_apart, {of_q[0], of_q[1], of_v[2]});
}

template <typename S>
Var causal_mask(Tape<S>& tape, Index steps) {
  const Var mask = tape.make({steps, steps});
  for (Index query = 0; query < steps; ++query) {
    for (Index key = 0; key < steps; ++key) {
      tape.data(mask)[query * steps + key] = key <= query ? S(1) : S(0);
    }
  }
  return mask;
}

#define INSTANTIATE(S)                                       \
  template Var attention(Tape<S>&, Var, Var, Var, int, Var); \
  template Var causal_mask(Tape<S>&, Index);
IMSLAM_NN_FOR_EACH_SCALAR(INSTANTIATE)

}  // namespace imslam::nn
