#include "slam/nn/ops/recurrent.hpp"

#include <algorithm>
#include <type_traits>

#include "slam/nn/kernels/instruction_set.hpp"
#include "slam/nn/ops/layout.hpp"
#include "slam/nn/ops/plain_convolution.hpp"
#include "slam/nn/ops/product.hpp"

namespace imslam::nn {
namespace {

/// Sample n, time t of a sequence [N,T,width].
struct Sequence {
  Index samples;
  Index steps;
  Index hidden;

  /// Offset of one row of an array of that width.
  Index at(Index n, Index t, Index width) const { return (n * steps + t) * width; }
};

template <typename S>
S sigmoid_of(const S& x) {
  using std::tanh;
  return S(0.5) + S(0.5) * tanh(S(0.5) * x);
}

/// One row of gates: from a and c (3H each) and h_{t-1} to h_t; gates = r, z, n, c_n (4H) are kept.
template <typename S>
void step_forward(Index H, const S* a, const S* c, const S* before, S* gates, S* h) {
  using std::tanh;
  for (Index i = 0; i < H; ++i) {
    const S r = sigmoid_of<S>(a[i] + c[i]);
    const S z = sigmoid_of<S>(a[H + i] + c[H + i]);
    const S n = tanh(S(a[2 * H + i] + r * c[2 * H + i]));
    gates[i] = r;
    gates[H + i] = z;
    gates[2 * H + i] = n;
    gates[3 * H + i] = c[2 * H + i];
    h[i] = (S(1) - z) * n + z * before[i];
  }
}

/// The same with Eigen's fast tanh of floats.
void step_forward(
    Index H, const float* a, const float* c, const float* before, float* gates, float* h) {
  using Row = Eigen::Map<Eigen::ArrayXf>;
  using ConstRow = Eigen::Map<const Eigen::ArrayXf>;
  const ConstRow c_n(c + 2 * H, H);
  Row rz(gates, 2 * H);
  Row n(gates + 2 * H, H);
  rz = 0.5F + 0.5F * (0.5F * (ConstRow(a, 2 * H) + ConstRow(c, 2 * H))).tanh();
  n = (ConstRow(a + 2 * H, H) + rz.head(H) * c_n).tanh();
  Row(gates + 3 * H, H) = c_n;
  Row(h, H) = (1.0F - rz.tail(H)) * n + rz.tail(H) * ConstRow(before, H);
}

/// Y = X W for the rows of one time.
template <typename S>
void product_of_step(Index rows, Index inner, Index columns, const S* x, const S* w, S* y) {
  if constexpr (std::is_same_v<S, float>) {
    kernels::selected_kernels().thin_product(
        {x, w, y, static_cast<int>(rows), static_cast<int>(inner), static_cast<int>(columns)});
  } else {
    MatrixMap<S>(y, rows, columns).noalias() =
        ConstMatrixMap<S>(x, rows, inner) * ConstMatrixMap<S>(w, inner, columns);
  }
}

/// One row back: dh is replaced by its direct part dh z; da, dc (3H each) are written.
template <typename S>
void step_backward(Index H, const S* gates, const S* before, S* dh, S* da, S* dc) {
  for (Index i = 0; i < H; ++i) {
    const S r = gates[i];
    const S z = gates[H + i];
    const S n = gates[2 * H + i];
    const S dn = dh[i] * (S(1) - z) * (S(1) - n * n);
    const S dz = dh[i] * (before[i] - n) * z * (S(1) - z);
    const S dr = dn * gates[3 * H + i] * r * (S(1) - r);
    da[i] = dc[i] = dr;
    da[H + i] = dc[H + i] = dz;
    da[2 * H + i] = dn;
    dc[2 * H + i] = dn * r;
    dh[i] = dh[i] * z;
  }
}

/// h_{t-1} of all samples as [N,H]: copied, because a sequence keeps samples apart.
template <typename S>
void copy_step(const Sequence& s, const S* h0, const S* y, Index t, S* before) {
  for (Index n = 0; n < s.samples; ++n) {
    const S* const from = t == 0 ? h0 + n * s.hidden : y + s.at(n, t - 1, s.hidden);
    std::copy_n(from, s.hidden, before + n * s.hidden);
  }
}

template <typename S>
void scan_forward(
    Tape<S>& tape, const Sequence& s, Var a, Var h0, Var wh, Var bh, S* gates, Var y) {
  const Index H = s.hidden;
  Scratch<S> scratch(tape);
  S* const before = scratch.template zeros<S>(s.samples * H);
  S* const c = scratch.template zeros<S>(s.samples * 3 * H);
  for (Index t = 0; t < s.steps; ++t) {
    copy_step(s, tape.data(h0), tape.data(y), t, before);
    product_of_step(s.samples, H, 3 * H, before, tape.data(wh), c);
    MatrixMap<S>(c, s.samples, 3 * H).rowwise() += tape.matrix(bh).row(0);
    for (Index n = 0; n < s.samples; ++n) {
      step_forward(H, tape.data(a) + s.at(n, t, 3 * H), c + n * 3 * H, before + n * H,
                   gates + s.at(n, t, 4 * H), tape.data(y) + s.at(n, t, H));
    }
  }
}

/// dWh += H_before^T dC and dbh += 1^T dC over all times at once.
template <typename S>
void add_weight_gradients(Tape<S>& tape, const Sequence& s, Var h0, Var wh, Var bh, Var y, S* dc) {
  const Index rows = s.samples * s.steps;
  const MatrixMap<S> dC(dc, rows, 3 * s.hidden);
  if (tape.wants_gradient(bh)) tape.gradient_matrix(bh) += dC.colwise().sum();
  if (!tape.wants_gradient(wh)) return;
  Scratch<S> scratch(tape);
  S* const before = scratch.template array<S>(rows * s.hidden);
  for (Index n = 0; n < s.samples; ++n) {
    S* const to = before + s.at(n, 0, s.hidden);
    std::copy_n(tape.data(h0) + n * s.hidden, s.hidden, to);
    std::copy_n(tape.data(y) + s.at(n, 0, s.hidden), (s.steps - 1) * s.hidden, to + s.hidden);
  }
  tape.accumulate_overwriting(wh, [&](S* dW) {
    S* const no_bias = nullptr;
    convolution_backward_weights(product_shape(rows, s.hidden, 3 * s.hidden), before, dc, dW,
                                 no_bias, tape.workspace());
  });
}

template <typename S>
void scan_backward(
    Tape<S>& tape, const Sequence& s, Var a, Var h0, Var wh, Var bh, const S* gates, Var y) {
  const Index H = s.hidden;
  Scratch<S> scratch(tape);
  S* const before = scratch.template zeros<S>(s.samples * H);
  S* const dh = scratch.template zeros<S>(s.samples * H);
  S* const by_next = scratch.template zeros<S>(s.samples * H);
  S* const da = scratch.template zeros<S>(3 * H);
  S* const dc = scratch.template zeros<S>(s.samples * 3 * H);
  S* const dc_all = scratch.template array<S>(s.samples * s.steps * 3 * H);
  S* const wh_transposed = scratch.template array<S>(3 * H * H);
  MatrixMap<S>(wh_transposed, 3 * H, H) = tape.matrix(wh).transpose();
  const S* const dY = tape.gradient_data(y);
  S* const dA = tape.wants_gradient(a) ? tape.gradient_data(a) : nullptr;
  for (Index t = s.steps - 1; t >= 0; --t) {
    copy_step(s, tape.data(h0), tape.data(y), t, before);
    for (Index n = 0; n < s.samples; ++n) {
      const S* const dy = dY + s.at(n, t, H);
      for (Index i = 0; i < H; ++i) dh[n * H + i] += dy[i];
      step_backward(H, gates + s.at(n, t, 4 * H), before + n * H, dh + n * H, da, dc + n * 3 * H);
      std::copy_n(dc + n * 3 * H, 3 * H, dc_all + s.at(n, t, 3 * H));
      if (dA == nullptr) continue;
      for (Index i = 0; i < 3 * H; ++i) dA[s.at(n, t, 3 * H) + i] += da[i];
    }
    product_of_step(s.samples, 3 * H, H, dc, wh_transposed, by_next);
    for (Index i = 0; i < s.samples * H; ++i) dh[i] += by_next[i];
  }
  tape.accumulate(h0, [&](ArrayMap<S> dH0) { dH0 += ArrayMap<S>(dh, s.samples * H); });
  add_weight_gradients(tape, s, h0, wh, bh, y, dc_all);
}

}  // namespace

template <typename S>
Var gru_scan(Tape<S>& tape, Var a, Var h0, Var wh, Var bh) {
  const Shape of_a = tape.shape(a);
  const Shape of_h = tape.shape(h0);
  expects_shapes(
      of_a.rank() == 3 && of_h.rank() == 2 && of_a[0] == of_h[0] && of_a[2] == 3 * of_h[1],
      "gru: a [N,T,3H] and h0 [N,H]", of_a, of_h);
  const Sequence s{of_a[0], of_a[1], of_h[1]};
  const Shape of_wh{s.hidden, 3 * s.hidden};
  expects_shapes(tape.shape(wh) == of_wh, "gru: wh [H,3H]", tape.shape(wh), of_wh);
  expects_shapes(tape.shape(bh) == Shape{3 * s.hidden}, "gru: bh [3H]", tape.shape(bh), of_wh);
  const Var y = tape.make({s.samples, s.steps, s.hidden});
  S* const gates = tape.template keep<S>(s.samples * s.steps * 4 * s.hidden);
  scan_forward(tape, s, a, h0, wh, bh, gates, y);
  return tape.record(y, {a, h0, wh, bh},
                     [=](Tape<S>& t) { scan_backward(t, s, a, h0, wh, bh, gates, y); });
}

template <typename S>
Var gru(Tape<S>& tape, Var x, Var h0, Var wx, Var bx, Var wh, Var bh) {
  return gru_scan(tape, linear(tape, x, wx, bx), h0, wh, bh);
}

template <typename S>
Var gru_cell(Tape<S>& tape, Var x, Var h, Var wx, Var bx, Var wh, Var bh) {
  const Shape of_x = tape.shape(x);
  expects_shape(of_x.rank() == 2, "gru_cell: x [N,I]", of_x);
  const Var sequence = reshape(tape, x, {of_x[0], 1, of_x[1]});
  return reshape(tape, gru(tape, sequence, h, wx, bx, wh, bh), tape.shape(h));
}

template <typename S>
Var last_state(Tape<S>& tape, Var y) {
  const Shape shape = tape.shape(y);
  expects_shape(shape.rank() == 3 && shape[1] >= 1, "last_state: y [N,T,H]", shape);
  return reshape(tape, slice(tape, y, 1, shape[1] - 1, 1), {shape[0], shape[2]});
}

#define INSTANTIATE(S)                                           \
  template Var gru_scan(Tape<S>&, Var, Var, Var, Var);           \
  template Var gru(Tape<S>&, Var, Var, Var, Var, Var, Var);      \
  template Var gru_cell(Tape<S>&, Var, Var, Var, Var, Var, Var); \
  template Var last_state(Tape<S>&, Var);
IMSLAM_NN_FOR_EACH_SCALAR(INSTANTIATE)

}  // namespace imslam::nn
