#include "slam/nn/ops/product.hpp"

#include "slam/nn/ops/convolution.hpp"
#include "slam/nn/ops/layout.hpp"
#include "slam/nn/ops/plain_convolution.hpp"

namespace imslam::nn {
namespace {

/// The offsets of the i-th matrices of a batch.
struct Batch {
  Index count;
  Index step_a;
  Index step_b;
  Index step_y;
};

template <typename S>
void matmul_backward(
    Tape<S>& t, const ConvolutionShape& s, const Batch& batch, Var a, Var b, Var y) {
  const S* const dY = t.gradient_data(y);
  t.accumulate_overwriting(a, [&](S* dA) {
    for (Index i = 0; i < batch.count; ++i) {
      convolution_backward_data(s, t.data(b) + i * batch.step_b, dY + i * batch.step_y,
                                dA + i * batch.step_a, t.workspace());
    }
  });
  t.accumulate_overwriting(b, [&](S* dB) {
    S* const no_bias = nullptr;
    for (Index i = 0; i < batch.count; ++i) {
      convolution_backward_weights(s, t.data(a) + i * batch.step_a, dY + i * batch.step_y,
                                   dB + i * batch.step_b, no_bias, t.workspace());
    }
  });
}

bool same_leading_axes(const Shape& a, const Shape& b) {
  if (a.rank() != b.rank()) return false;
  for (int axis = 0; axis + 2 < a.rank(); ++axis) {
    if (a[axis] != b[axis]) return false;
  }
  return true;
}

}  // namespace

ConvolutionShape product_shape(Index rows, Index inner, Index columns) {
  ConvolutionShape s;
  s.in_width = static_cast<int>(rows);
  s.in_channels = static_cast<int>(inner);
  s.out_channels = static_cast<int>(columns);
  return s;
}

template <typename S>
Var linear(Tape<S>& tape, Var x, Var w, Var b, Activation activation) {
  const Shape of_x = tape.shape(x);
  const Shape of_w = tape.shape(w);
  expects_shapes(of_x.rank() >= 1 && of_w.rank() == 2 && of_x.channels() == of_w[0],
                 "linear: x [...,Cin] and w [Cin,Cout]", of_x, of_w);
  const Shape of_y = of_x.with_channels(of_w[1]);
  if (of_x.rows() == 0) return tape.make(of_y);
  const Var pixels = reshape(tape, x, {1, 1, of_x.rows(), of_w[0]});
  const Var kernel = reshape(tape, w, {1, 1, of_w[0], of_w[1]});
  ConvolutionOptions options;
  options.activation = activation;
  return reshape(tape, conv2d(tape, pixels, kernel, b, options), of_y);
}

template <typename S>
Var matmul(Tape<S>& tape, Var a, Var b) {
  const Shape of_a = tape.shape(a);
  const Shape of_b = tape.shape(b);
  expects_shapes(of_a.rank() >= 2 && of_b.rank() >= 2 && of_a[-1] == of_b[-2],
                 "matmul: a [...,M,K] and b [...,K,N]", of_a, of_b);
  const bool shared = of_b.rank() == 2;
  if (shared) return linear(tape, a, b, Var{});
  expects_shapes(same_leading_axes(of_a, of_b), "matmul: the leading axes agree", of_a, of_b);
  const Shape of_y = of_a.with_channels(of_b[-1]);
  const Var y = tape.make(of_y);
  if (of_y.size() == 0) return y;
  const Index M = of_a[-2];
  const Index K = of_a[-1];
  const Index N = of_b[-1];
  const ConvolutionShape s = product_shape(M, K, N);
  const Batch batch{of_y.size() / (M * N), M * K, K * N, M * N};
  const S* const no_bias = nullptr;
  for (Index i = 0; i < batch.count; ++i) {
    convolution_forward(s, tape.data(a) + i * batch.step_a, tape.data(b) + i * batch.step_b,
                        no_bias, Activation::kNone, tape.data(y) + i * batch.step_y,
                        tape.workspace());
  }
  return tape.record(y, {a, b}, [=](Tape<S>& t) { matmul_backward(t, s, batch, a, b, y); });
}

template <typename S>
Var transpose(Tape<S>& tape, Var x) {
  const int rank = tape.shape(x).rank();
  expects_shape(rank >= 2, "transpose: two axes or more", tape.shape(x));
  std::array<int, Shape::kMaxRank> axes{0, 1, 2, 3, 4};
  std::swap(axes[static_cast<std::size_t>(rank - 2)], axes[static_cast<std::size_t>(rank - 1)]);
  return permute(tape, x, axes.data(), rank);
}

#define INSTANTIATE(S)                                      \
  template Var linear(Tape<S>&, Var, Var, Var, Activation); \
  template Var matmul(Tape<S>&, Var, Var);                  \
  template Var transpose(Tape<S>&, Var);
IMSLAM_NN_FOR_EACH_SCALAR(INSTANTIATE)

}  // namespace imslam::nn
