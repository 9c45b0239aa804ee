#pragma once

#include <array>

#include "slam/nn/tape.hpp"

namespace imslam::nn {

/// An input of a formula: `width` numbers of it per evaluation.
struct Operand {
  Var var;
  Index width = 1;
};

/// y_i = f(all operands' numbers of place i), one number per place, differentiated by dual numbers:
/// for losses and the like, where the formula should stand alone and speed does not matter.
///
///   f: template <T> T operator()(const std::array<T, kNumbers>&) const;  plain data, no pointers
///   y has the shape `shape`; each operand has shape.size() * width numbers
template <std::size_t kNumbers, typename S, std::size_t kOperands, typename F>
Var formula(Tape<S>& tape,
            const Shape& shape,
            const std::array<Operand, kOperands>& operands,
            F f) {
  for (const Operand& o : operands) {
    expects_shapes(tape.shape(o.var).size() == shape.size() * o.width, "loss: sizes agree",
                   tape.shape(o.var), shape);
  }
  // Reads place i; with tangent 1 at number `active` if T is dual.
  const auto read = [operands](Tape<S>& t, Index i) {
    std::array<S, kNumbers> x{};
    std::size_t n = 0;
    for (const Operand& o : operands) {
      for (Index k = 0; k < o.width; ++k) x[n++] = t.data(o.var)[i * o.width + k];
    }
    return x;
  };
  const Var y = tape.make(shape);
  for (Index i = 0; i < shape.size(); ++i) tape.data(y)[i] = f(read(tape, i));
  std::array<Var, kOperands> vars;
  for (std::size_t i = 0; i < kOperands; ++i) vars[i] = operands[i].var;
  return tape.record(y, vars.data(), vars.size(), [=](Tape<S>& t) {
    const S* const dY = t.gradient_data(y);
    std::size_t first = 0;
    for (const Operand& o : operands) {
      if (t.wants_gradient(o.var)) {
        S* const dX = t.gradient_data(o.var);
        for (Index i = 0; i < t.shape(y).size(); ++i) {
          const std::array<S, kNumbers> x = read(t, i);
          std::array<Dual<S>, kNumbers> dual;
          for (std::size_t n = 0; n < kNumbers; ++n) dual[n] = Dual<S>(x[n], S(0));
          for (Index k = 0; k < o.width; ++k) {
            Dual<S>& active = dual[first + static_cast<std::size_t>(k)];
            active.tangent = S(1);
            dX[i * o.width + k] += dY[i] * f(dual).tangent;
            active.tangent = S(0);
          }
        }
      }
      first += static_cast<std::size_t>(o.width);
    }
  });
}

}  // namespace imslam::nn
