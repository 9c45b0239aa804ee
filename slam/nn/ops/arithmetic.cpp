#include "slam/nn/ops/arithmetic.hpp"

#include "slam/nn/ops/broadcast.hpp"

namespace imslam::nn {
namespace {

struct Add {
  template <typename S>
  static S value(S a, S b) {
    return a + b;
  }
  template <typename S>
  static S to_a(S dy, S, S) {
    return dy;
  }
  template <typename S>
  static S to_b(S dy, S, S) {
    return dy;
  }
};

struct Subtract {
  template <typename S>
  static S value(S a, S b) {
    return a - b;
  }
  template <typename S>
  static S to_a(S dy, S, S) {
    return dy;
  }
  template <typename S>
  static S to_b(S dy, S, S) {
    return -dy;
  }
};

struct Multiply {
  template <typename S>
  static S value(S a, S b) {
    return a * b;
  }
  template <typename S>
  static S to_a(S dy, S, S b) {
    return dy * b;
  }
  template <typename S>
  static S to_b(S dy, S a, S) {
    return dy * a;
  }
};

struct Divide {
  template <typename S>
  static S value(S a, S b) {
    return a / b;
  }
  template <typename S>
  static S to_a(S dy, S, S b) {
    return dy / b;
  }
  template <typename S>
  static S to_b(S dy, S a, S b) {
    return -(dy * a) / (b * b);
  }
};

/// Calls body(step_a, step_b) with steps that the compiler knows, so that it can vectorise.
template <typename Body>
void with_steps(const BroadcastLoop& loop, const Body& body) {
  using Zero = std::integral_constant<Index, 0>;
  using One = std::integral_constant<Index, 1>;
  if (loop.step_a() == 1 && loop.step_b() == 1) return body(One(), One());
  if (loop.step_a() == 1) return body(One(), Zero());
  if (loop.step_b() == 1) return body(Zero(), One());
  return body(Zero(), Zero());
}

template <typename Op, typename S>
void forward(const BroadcastLoop& loop, const S* A, const S* B, S* Y) {
  with_steps(loop, [&](auto step_a, auto step_b) {
    loop.for_each_row([&](Index at, Index at_a, Index at_b) {
      const S* const a = A + at_a;
      const S* const b = B + at_b;
      S* const y = Y + at;
      for (Index i = 0; i < loop.length(); ++i) y[i] = Op::value(a[i * step_a], b[i * step_b]);
    });
  });
}

/// dOperand[...] += term(dy, a, b), summed over a row first where the operand is repeated in it.
template <typename Step, typename Term, typename S>
void add_row(Step step, Index length, const Term& term, S* d) {
  if constexpr (Step::value == 1) {
    for (Index i = 0; i < length; ++i) d[i] += term(i);
  } else {
    (void)step;
    Wide<S> sum(0);
    for (Index i = 0; i < length; ++i) sum += Wide<S>(term(i));
    *d += S(sum);
  }
}

template <typename Op, typename S>
void backward(Tape<S>& t, Var a, Var b, Var y) {
  const BroadcastLoop loop(t.shape(y), t.shape(a), t.shape(b));
  const S* const A = t.data(a);
  const S* const B = t.data(b);
  const S* const dY = t.gradient_data(y);
  S* const dA = t.wants_gradient(a) ? t.gradient_data(a) : nullptr;
  S* const dB = t.wants_gradient(b) ? t.gradient_data(b) : nullptr;
  with_steps(loop, [&](auto sa, auto sb) {
    loop.for_each_row([&](Index at, Index at_a, Index at_b) {
      const S* const p = A + at_a;
      const S* const q = B + at_b;
      const S* const dy = dY + at;
      const auto to_a = [&](Index i) { return Op::to_a(dy[i], p[i * sa], q[i * sb]); };
      const auto to_b = [&](Index i) { return Op::to_b(dy[i], p[i * sa], q[i * sb]); };
      if (dA != nullptr) add_row(sa, loop.length(), to_a, dA + at_a);
      if (dB != nullptr) add_row(sb, loop.length(), to_b, dB + at_b);
    });
  });
}

template <typename Op, typename S>
Var combine(Tape<S>& tape, Var a, Var b) {
  const Shape full = broadcast_shape(tape.shape(a), tape.shape(b));
  const Var y = tape.make(full);
  forward<Op>(BroadcastLoop(full, tape.shape(a), tape.shape(b)), tape.data(a), tape.data(b),
              tape.data(y));
  return tape.record(y, {a, b}, [a, b, y](Tape<S>& t) { backward<Op>(t, a, b, y); });
}

}  // namespace

template <typename S>
Var add(Tape<S>& tape, Var a, Var b) {
  return combine<Add>(tape, a, b);
}

template <typename S>
Var subtract(Tape<S>& tape, Var a, Var b) {
  return combine<Subtract>(tape, a, b);
}

template <typename S>
Var multiply(Tape<S>& tape, Var a, Var b) {
  return combine<Multiply>(tape, a, b);
}

template <typename S>
Var divide(Tape<S>& tape, Var a, Var b) {
  return combine<Divide>(tape, a, b);
}

#define INSTANTIATE(S)                       \
  template Var add(Tape<S>&, Var, Var);      \
  template Var subtract(Tape<S>&, Var, Var); \
  template Var multiply(Tape<S>&, Var, Var); \
  template Var divide(Tape<S>&, Var, Var);
IMSLAM_NN_FOR_EACH_SCALAR(INSTANTIATE)

}  // namespace imslam::nn
