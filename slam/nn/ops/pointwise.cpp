#include "slam/nn/ops/pointwise.hpp"

#include "slam/nn/ops/elementwise.hpp"

namespace imslam::nn {

template <typename S>
Var exp(Tape<S>& tape, Var x) {
  return elementwise(
      tape, x,  //
      [](auto X, auto Y) { Y = X.exp(); }, [](auto, auto Y, auto dY, auto dX) { dX += dY * Y; });
}

template <typename S>
Var log(Tape<S>& tape, Var x) {
  return elementwise(
      tape, x,  //
      [](auto X, auto Y) { Y = X.log(); }, [](auto X, auto, auto dY, auto dX) { dX += dY / X; });
}

template <typename S>
Var sqrt(Tape<S>& tape, Var x) {
  return elementwise(
      tape, x,  //
      [](auto X, auto Y) { Y = X.sqrt(); },
      [](auto, auto Y, auto dY, auto dX) { dX += S(0.5) * dY / Y; });
}

template <typename S>
Var abs(Tape<S>& tape, Var x) {
  return elementwise(
      tape, x,  //
      [](auto X, auto Y) { Y = (X < S(0)).select(-X, X); },
      [](auto X, auto, auto dY, auto dX) {
        dX += (X < S(0)).select(-dY, (X > S(0)).select(dY, S(0)));
      });
}

template <typename S>
Var square(Tape<S>& tape, Var x) {
  return elementwise(
      tape, x,  //
      [](auto X, auto Y) { Y = X * X; },
      [](auto X, auto, auto dY, auto dX) { dX += S(2) * dY * X; });
}

template <typename S>
Var clamp(Tape<S>& tape, Var x, double low, double high) {
  expects(low <= high, "clamp: low must not exceed high");
  return elementwise(
      tape, x,
      [low, high](auto X, auto Y) {
        Y = (X < S(low)).select(S(low), (X > S(high)).select(S(high), X));
      },
      [low, high](auto X, auto, auto dY, auto dX) {
        dX += (X > S(low) && X < S(high)).select(dY, S(0));
      });
}

template <typename S>
Var scale(Tape<S>& tape, Var x, double factor) {
  return elementwise(
      tape, x,  //
      [factor](auto X, auto Y) { Y = S(factor) * X; },
      [factor](auto, auto, auto dY, auto dX) { dX += S(factor) * dY; });
}

template <typename S>
Var shift(Tape<S>& tape, Var x, double offset) {
  return elementwise(
      tape, x,  //
      [offset](auto X, auto Y) { Y = X + S(offset); },
      [](auto, auto, auto dY, auto dX) { dX += dY; });
}

template <typename S>
Var stop_gradient(Tape<S>& tape, Var x) {
  return tape.alias(x, tape.shape(x));
}

#define INSTANTIATE(S)                               \
  template Var exp(Tape<S>&, Var);                   \
  template Var log(Tape<S>&, Var);                   \
  template Var sqrt(Tape<S>&, Var);                  \
  template Var abs(Tape<S>&, Var);                   \
  template Var square(Tape<S>&, Var);                \
  template Var clamp(Tape<S>&, Var, double, double); \
  template Var scale(Tape<S>&, Var, double);         \
  template Var shift(Tape<S>&, Var, double);         \
  template Var stop_gradient(Tape<S>&, Var);
IMSLAM_NN_FOR_EACH_SCALAR(INSTANTIATE)

}  // namespace imslam::nn
