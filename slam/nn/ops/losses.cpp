#include "slam/nn/ops/losses.hpp"

#include <cmath>

#include "slam/nn/ops/arithmetic.hpp"
#include "slam/nn/ops/formula.hpp"
#include "slam/nn/ops/gather.hpp"
#include "slam/nn/ops/pointwise.hpp"
#include "slam/nn/ops/reduce.hpp"
#include "slam/nn/ops/softmax.hpp"

namespace imslam::nn {
namespace {

constexpr double kPi = 3.14159265358979323846;

/// std::lgamma writes a global sign, which tapes of other threads would write too.
double log_gamma(double x) {
  int sign = 0;
  return ::lgamma_r(x, &sign);
}

struct Huber {
  double delta;
  template <typename T>
  T operator()(const std::array<T, 2>& x) const {
    const T r = x[0] < x[1] ? x[1] - x[0] : x[0] - x[1];
    if (r <= T(delta)) return T(0.5) * r * r;
    return T(delta) * (r - T(0.5 * delta));
  }
};

struct BinaryCrossEntropy {
  template <typename T>
  T operator()(const std::array<T, 2>& x) const {
    using std::exp;
    using std::log1p;
    const T positive = x[0] > T(0.0) ? x[0] : T(0.0);
    const T minus_size = x[0] > T(0.0) ? -x[0] : x[0];
    return positive - x[0] * x[1] + T(log1p(T(exp(minus_size))));
  }
};

struct GaussianNll {
  template <typename T>
  T operator()(const std::array<T, 2>& x) const {
    using std::exp;
    const T whitened = x[0] * T(exp(-x[1]));
    return x[1] + T(0.5) * whitened * whitened + T(0.5 * std::log(2.0 * kPi));
  }
};

struct StudentNll {
  explicit StudentNll(double degrees)
      : nu(degrees),
        constant(0.5 * std::log(nu * kPi) + log_gamma(0.5 * nu) - log_gamma(0.5 * (nu + 1.0))) {}

  template <typename T>
  T operator()(const std::array<T, 2>& x) const {
    using std::exp;
    using std::log1p;
    const T whitened = x[0] * T(exp(-x[1]));
    return x[1] + T(0.5 * (nu + 1.0)) * T(log1p(T(whitened * whitened * T(1.0 / nu)))) +
           T(constant);
  }

  double nu;
  double constant;
};

struct StudentNll2d {
  explicit StudentNll2d(double degrees)
      : nu(degrees),
        constant(std::log(nu * kPi) + log_gamma(0.5 * nu) - log_gamma(0.5 * (nu + 2.0))) {}

  /// x = r_0, r_1, s_0, s_1, l
  template <typename T>
  T operator()(const std::array<T, 5>& x) const {
    using std::exp;
    using std::log1p;
    const T first = x[0] * T(exp(-x[2]));
    const T second = (x[1] - x[4] * first) * T(exp(-x[3]));
    const T square = first * first + second * second;
    return x[2] + x[3] + T(0.5 * (nu + 2.0)) * T(log1p(T(square * T(1.0 / nu)))) + T(constant);
  }

  double nu;
  double constant;
};

/// Two inputs of one shape, number by number.
template <typename S, typename F>
Var pairwise(Tape<S>& tape, Var a, Var b, F f) {
  expects_shapes(tape.shape(a) == tape.shape(b), "loss: the same shape", tape.shape(a),
                 tape.shape(b));
  return formula<2>(tape, tape.shape(a), std::array<Operand, 2>{Operand{a, 1}, Operand{b, 1}}, f);
}

}  // namespace

template <typename S>
Var absolute_error(Tape<S>& tape, Var x, Var target) {
  return abs(tape, subtract(tape, x, target));
}

template <typename S>
Var squared_error(Tape<S>& tape, Var x, Var target) {
  return square(tape, subtract(tape, x, target));
}

template <typename S>
Var huber(Tape<S>& tape, Var x, Var target, double delta) {
  expects(delta > 0.0, "huber: delta must be positive");
  return pairwise(tape, x, target, Huber{delta});
}

template <typename S>
Var cross_entropy(Tape<S>& tape, Var logits, const std::vector<std::int32_t>& classes) {
  return scale(tape, pick(tape, log_softmax(tape, logits), classes), -1.0);
}

template <typename S>
Var soft_cross_entropy(Tape<S>& tape, Var logits, Var targets) {
  expects_shapes(tape.shape(logits) == tape.shape(targets), "soft_cross_entropy: the same shape",
                 tape.shape(logits), tape.shape(targets));
  const Var terms = multiply(tape, log_softmax(tape, logits), targets);
  return scale(tape, sum(tape, terms, {-1}), -1.0);
}

template <typename S>
Var binary_cross_entropy_with_logits(Tape<S>& tape, Var logits, Var targets) {
  return pairwise(tape, logits, targets, BinaryCrossEntropy{});
}

template <typename S>
Var gaussian_nll(Tape<S>& tape, Var residual, Var log_sigma) {
  return pairwise(tape, residual, log_sigma, GaussianNll{});
}

template <typename S>
Var student_t_nll(Tape<S>& tape, Var residual, Var log_sigma, double nu) {
  expects(nu > 0.0, "student_t_nll: nu must be positive");
  return pairwise(tape, residual, log_sigma, StudentNll(nu));
}

template <typename S>
Var student_t_nll_2d(Tape<S>& tape, Var residual, Var factor, double nu) {
  const Shape shape = tape.shape(residual);
  expects(nu > 0.0, "student_t_nll_2d: nu must be positive");
  expects_shapes(
      shape.rank() >= 1 && shape.channels() == 2 && tape.shape(factor) == shape.with_channels(3),
      "student_t_nll_2d: residual [...,2] and factor [...,3]", shape, tape.shape(factor));
  return formula<5>(tape, shape.without(-1),
                    std::array<Operand, 2>{Operand{residual, 2}, Operand{factor, 3}},
                    StudentNll2d(nu));
}

#define INSTANTIATE(S)                                                         \
  template Var absolute_error(Tape<S>&, Var, Var);                             \
  template Var squared_error(Tape<S>&, Var, Var);                              \
  template Var huber(Tape<S>&, Var, Var, double);                              \
  template Var cross_entropy(Tape<S>&, Var, const std::vector<std::int32_t>&); \
  template Var soft_cross_entropy(Tape<S>&, Var, Var);                         \
  template Var binary_cross_entropy_with_logits(Tape<S>&, Var, Var);           \
  template Var gaussian_nll(Tape<S>&, Var, Var);                               \
  template Var student_t_nll(Tape<S>&, Var, Var, double);                      \
  template Var student_t_nll_2d(Tape<S>&, Var, Var, double);
IMSLAM_NN_FOR_EACH_SCALAR(INSTANTIATE)

}  // namespace imslam::nn
