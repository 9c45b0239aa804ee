#include "slam/nn/ops/activation.hpp"

#include <type_traits>

#include "slam/nn/kernels/instruction_set.hpp"

#include "slam/nn/ops/elementwise.hpp"

namespace imslam::nn {
namespace {

/// sigmoid(x) = (1 + tanh(x/2)) / 2: overflows nowhere, unlike 1 / (1 + e^-x).
template <typename S, typename Array>
Eigen::Array<S, Eigen::Dynamic, 1> sigmoid_of(const Array& X) {
  return S(0.5) + S(0.5) * (S(0.5) * X).tanh();
}

constexpr double kGeluScale = 0.7978845608028654;  // sqrt(2/pi)
constexpr double kGeluCubic = 0.044715;

}  // namespace

template <typename S>
Var relu(Tape<S>& tape, Var x) {
  return elementwise(
      tape, x,  //
      [](auto X, auto Y) { Y = (X < S(0)).select(S(0), X); },
      [](auto, auto Y, auto dY, auto dX) {
        S* const d = dX.data();
        through_relu(Y.size(), Y.data(), dY.data(), S(0), [d](Index i, S v) { d[i] += v; });
      });
}

template <typename S>
Var add_relu(Tape<S>& tape, Var a, Var b) {
  expects_shapes(tape.shape(a) == tape.shape(b), "add_relu: two of one shape", tape.shape(a),
                 tape.shape(b));
  const Var y = tape.make(tape.shape(a));
  const Index count = tape.shape(a).size();
  if constexpr (std::is_same_v<S, float>) {
    kernels::selected_kernels().add_relu(tape.data(a), tape.data(b), count, tape.data(y));
  } else {
    const Eigen::Array<S, Eigen::Dynamic, 1> sum = tape.array(a) + tape.array(b);
    tape.array(y) = (sum < S(0)).select(S(0), sum);
  }
  return tape.record(y, {a, b}, [=](Tape<S>& t) {
    for (const Var to : {a, b}) {
      t.accumulate(to, [&](ArrayMap<S> dX) {
        through_relu(count, t.data(y), t.gradient_data(y), S(0),
                     [d = dX.data()](Index i, S v) { d[i] += v; });
      });
    }
  });
}

template <typename S>
Var leaky_relu(Tape<S>& tape, Var x, double slope) {
  expects(slope >= 0.0, "leaky_relu: slope must not be negative");
  return elementwise(
      tape, x,  //
      [slope](auto X, auto Y) { Y = (X > S(0)).select(X, S(slope) * X); },
      [slope](auto, auto Y, auto dY, auto dX) {
        S* const d = dX.data();
        through_relu(Y.size(), Y.data(), dY.data(), S(slope), [d](Index i, S v) { d[i] += v; });
      });
}

template <typename S>
Var elu(Tape<S>& tape, Var x) {
  return elementwise(
      tape, x,  //
      [](auto X, auto Y) { Y = (X > S(0)).select(X, (X < S(0)).select(X, S(0)).exp() - S(1)); },
      [](auto X, auto Y, auto dY, auto dX) { dX += (X > S(0)).select(dY, dY * (Y + S(1))); });
}

template <typename S>
Var gelu(Tape<S>& tape, Var x) {
  return elementwise(
      tape, x,
      [](auto X, auto Y) {
        Y = S(0.5) * X * (S(1) + (S(kGeluScale) * (X + S(kGeluCubic) * X * X * X)).tanh());
      },
      [](auto X, auto, auto dY, auto dX) {
        const Eigen::Array<S, Eigen::Dynamic, 1> t =
            (S(kGeluScale) * (X + S(kGeluCubic) * X * X * X)).tanh();
        dX += dY * (S(0.5) * (S(1) + t) +
                    S(0.5 * kGeluScale) * X * (S(1) - t * t) * (S(1) + S(3 * kGeluCubic) * X * X));
      });
}

template <typename S>
Var silu(Tape<S>& tape, Var x) {
  return elementwise(
      tape, x,  //
      [](auto X, auto Y) { Y = X * (S(0.5) + S(0.5) * (S(0.5) * X).tanh()); },
      [](auto X, auto, auto dY, auto dX) {
        const Eigen::Array<S, Eigen::Dynamic, 1> s = sigmoid_of<S>(X);
        dX += dY * s * (S(1) + X * (S(1) - s));
      });
}

template <typename S>
Var tanh(Tape<S>& tape, Var x) {
  return elementwise(
      tape, x,  //
      [](auto X, auto Y) { Y = X.tanh(); },
      [](auto, auto Y, auto dY, auto dX) { dX += dY * (S(1) - Y * Y); });
}

template <typename S>
Var sigmoid(Tape<S>& tape, Var x) {
  return elementwise(
      tape, x,  //
      [](auto X, auto Y) { Y = S(0.5) + S(0.5) * (S(0.5) * X).tanh(); },
      [](auto, auto Y, auto dY, auto dX) { dX += dY * Y * (S(1) - Y); });
}

template <typename S>
Var softplus(Tape<S>& tape, Var x) {
  return elementwise(
      tape, x,
      // max(x, 0) + log(1 + e^-|x|) overflows nowhere.
      [](auto X, auto Y) {
        Y = (X > S(0)).select(X, S(0)) + (S(1) + (X > S(0)).select(-X, X).exp()).log();
      },
      [](auto X, auto, auto dY, auto dX) { dX += dY * sigmoid_of<S>(X); });
}

#define INSTANTIATE(S)                            \
  template Var relu(Tape<S>&, Var);               \
  template Var add_relu(Tape<S>&, Var, Var);      \
  template Var leaky_relu(Tape<S>&, Var, double); \
  template Var elu(Tape<S>&, Var);                \
  template Var gelu(Tape<S>&, Var);               \
  template Var silu(Tape<S>&, Var);               \
  template Var tanh(Tape<S>&, Var);               \
  template Var sigmoid(Tape<S>&, Var);            \
  template Var softplus(Tape<S>&, Var);
IMSLAM_NN_FOR_EACH_SCALAR(INSTANTIATE)

}  // namespace imslam::nn
