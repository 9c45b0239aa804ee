#pragma once

#include <gtest/gtest.h>

#include <type_traits>
#include <vector>

#include "slam/base/random.hpp"
#include "slam/nn/tape.hpp"

namespace imslam::nn::testing {

struct CheckOptions {
  double low = -1.0;  ///< inputs are drawn from [low, high)
  double high = 1.0;
  double tolerance = 1e-7;        ///< double against central differences
  double float_tolerance = 3e-5;  ///< float against double
};

template <typename T>
using ScalarOf = std::remove_const_t<
    std::remove_pointer_t<decltype(std::declval<T&>().gradient_data(std::declval<Var>()))>>;

/// A constant from doubles on a tape of any scalar.
template <typename T>
Var constant(T& tape, const Tensor<double>& numbers) {
  return tape.constant(cast<ScalarOf<T>>(numbers));
}

inline Tensor<double> random_tensor(const Shape& shape, Random& random, double low, double high) {
  Tensor<double> tensor(shape);
  for (Index i = 0; i < tensor.size(); ++i) tensor[i] = random.uniform(low, high);
  return tensor;
}

template <typename S>
struct Pass {
  Tensor<S> y;
  std::vector<Tensor<S>> gradients;  ///< of L = sum(seed y), one per input
};

/// Runs build(tape, inputs) forward and, for a non-empty seed, backward.
template <typename S, typename Build>
Pass<S> run_op(const Build& build,
               const std::vector<Tensor<S>>& inputs,
               const Tensor<double>* seed,
               Mode mode = Mode::kTraining) {
  Tape<S> tape(mode);
  std::vector<Var> vars;
  for (const Tensor<S>& input : inputs) vars.push_back(tape.input(input));
  const Var y = build(tape, vars);
  Pass<S> pass;
  pass.y = tape.copy(y);
  if (seed == nullptr) return pass;
  tape.backward(y, cast<S>(*seed));
  for (const Var v : vars) {
    Tensor<S> gradient(tape.shape(v));
    gradient.array() = tape.gradient(v);
    pass.gradients.push_back(gradient);
  }
  return pass;
}

/// Relative to the largest expected number, absolute below 1.
inline void expect_close(const Tensor<double>& actual,
                         const Tensor<double>& expected,
                         double tolerance,
                         const std::string& what) {
  ASSERT_EQ(actual.shape().text(), expected.shape().text()) << what;
  double scale = 1.0;
  for (Index i = 0; i < expected.size(); ++i) scale = std::max(scale, std::abs(expected[i]));
  for (Index i = 0; i < expected.size(); ++i) {
    ASSERT_LE(std::abs(actual[i] - expected[i]), tolerance * scale)
        << what << " [" << i << "]: " << actual[i] << ", expected " << expected[i];
  }
}

template <typename S>
std::vector<Tensor<S>> cast_all(const std::vector<Tensor<double>>& from) {
  std::vector<Tensor<S>> to;
  for (const auto& tensor : from) to.push_back(cast<S>(tensor));
  return to;
}

inline Tensor<double> tangent_of(const Tensor<Dual<double>>& dual) {
  Tensor<double> tangent(dual.shape());
  for (Index i = 0; i < dual.size(); ++i) tangent[i] = dual[i].tangent;
  return tangent;
}

/// x + step v for all inputs.
inline std::vector<Tensor<double>> moved(const std::vector<Tensor<double>>& x,
                                         const std::vector<Tensor<double>>& v,
                                         double step) {
  std::vector<Tensor<double>> y;
  for (std::size_t i = 0; i < x.size(); ++i) {
    y.push_back(x[i].clone());
    y.back().array() += step * v[i].array();
  }
  return y;
}

inline Tensor<double> slope(const Tensor<double>& ahead,
                            const Tensor<double>& behind,
                            double step) {
  Tensor<double> difference(ahead.shape());
  difference.array() = (ahead.array() - behind.array()) / (2 * step);
  return difference;
}

template <typename Build>
void check_gradients(const Build& build,
                     const std::vector<Tensor<double>>& inputs,
                     const Tensor<double>& seed,
                     const Pass<double>& exact,
                     double tolerance) {
  constexpr double kStep = 1e-6;
  const auto loss = [&](const std::vector<Tensor<double>>& at) {
    return (run_op<double>(build, at, nullptr).y.array() * seed.array()).sum();
  };
  for (std::size_t k = 0; k < inputs.size(); ++k) {
    Tensor<double> numeric(inputs[k].shape());
    for (Index i = 0; i < numeric.size(); ++i) {
      std::vector<Tensor<double>> at = inputs;
      at[k] = inputs[k].clone();
      at[k][i] = inputs[k][i] + kStep;
      const double ahead = loss(at);
      at[k][i] = inputs[k][i] - kStep;
      numeric[i] = (ahead - loss(at)) / (2 * kStep);
    }
    expect_close(exact.gradients[k], numeric, tolerance, "gradient of input " + std::to_string(k));
  }
}

/// Sent back twice, every gradient is twice as large: operations add to what is there.
template <typename S, typename Build>
void check_accumulation(const Build& build,
                        const std::vector<Tensor<S>>& inputs,
                        const Tensor<double>& seed,
                        const Pass<S>& once) {
  Tape<S> tape;
  std::vector<Var> vars;
  for (const Tensor<S>& input : inputs) vars.push_back(tape.input(input));
  const Var y = build(tape, vars);
  tape.backward(y, cast<S>(seed));
  tape.backward(y, cast<S>(seed));
  for (std::size_t k = 0; k < inputs.size(); ++k) {
    Tensor<double> half(inputs[k].shape());
    const Tensor<S>& expected = once.gradients[k];
    const ArrayMap<S> twice = tape.gradient(vars[k]);
    for (Index i = 0; i < half.size(); ++i) half[i] = 0.5 * static_cast<double>(twice[i]);
    expect_close(half, cast<double>(expected), 1e-6, "accumulated gradient " + std::to_string(k));
  }
}

/// Dual numbers: tangents of values and of gradients along a random direction.
template <typename Build>
void check_tangents(const Build& build,
                    const std::vector<Tensor<double>>& inputs,
                    const Tensor<double>& seed,
                    Random& random,
                    double tolerance) {
  constexpr double kStep = 1e-6;
  std::vector<Tensor<double>> direction;
  std::vector<Tensor<Dual<double>>> dual;
  for (const auto& input : inputs) {
    direction.push_back(random_tensor(input.shape(), random, -1.0, 1.0));
    dual.emplace_back(input.shape());
    for (Index i = 0; i < input.size(); ++i) dual.back()[i] = {input[i], direction.back()[i]};
  }
  const auto pass = run_op<Dual<double>>(build, dual, &seed);
  const auto ahead = run_op<double>(build, moved(inputs, direction, kStep), &seed);
  const auto behind = run_op<double>(build, moved(inputs, direction, -kStep), &seed);
  expect_close(tangent_of(pass.y), slope(ahead.y, behind.y, kStep), tolerance, "tangent of y");
  for (std::size_t k = 0; k < inputs.size(); ++k) {
    expect_close(tangent_of(pass.gradients[k]),
                 slope(ahead.gradients[k], behind.gradients[k], kStep), tolerance,
                 "tangent of gradient " + std::to_string(k));
  }
}

/// All that an operation promises, at random inputs: gradients are those of central differences in
/// double, add to what is there, float agrees with double, dual tangents agree with differences,
/// inference gives the same bytes as training. build(tape, vars) -> Var is generic over the tape.
template <typename Build>
void check_op(const Build& build, const std::vector<Shape>& shapes, const CheckOptions& o = {}) {
  Random random(7);
  std::vector<Tensor<double>> inputs;
  for (const Shape& shape : shapes) inputs.push_back(random_tensor(shape, random, o.low, o.high));
  const Shape of_y = run_op<double>(build, inputs, nullptr).y.shape();
  const Tensor<double> seed = random_tensor(of_y, random, -1.0, 1.0);

  const auto exact = run_op<double>(build, inputs, &seed);
  check_gradients(build, inputs, seed, exact, o.tolerance);
  check_accumulation<double>(build, inputs, seed, exact);
  check_tangents(build, inputs, seed, random, 10 * o.tolerance);

  const auto fast = run_op<float>(build, cast_all<float>(inputs), &seed);
  expect_close(cast<double>(fast.y), exact.y, o.float_tolerance, "float y");
  for (std::size_t k = 0; k < inputs.size(); ++k) {
    expect_close(cast<double>(fast.gradients[k]), exact.gradients[k], o.float_tolerance,
                 "float gradient " + std::to_string(k));
  }
  check_accumulation<float>(build, cast_all<float>(inputs), seed, fast);
  const auto plain = run_op<float>(build, cast_all<float>(inputs), nullptr, Mode::kInference);
  expect_close(cast<double>(plain.y), cast<double>(fast.y), 0.0, "inference");
}

}  // namespace imslam::nn::testing
