#include "slam/learner/imperative_loss.hpp"

#include <algorithm>

namespace imslam::learner {

template <typename S>
Vector numbers_of(const nn::Tape<S>& tape, nn::Var z) {
  const nn::Index count = tape.shape(z).size();
  Vector numbers(count);
  std::copy_n(tape.data(z), count, numbers.data());
  return numbers;
}

template <typename S>
nn::Var imperative_loss(nn::Tape<S>& tape, nn::Var z, const UpperGradient& upper) {
  const nn::Var y = tape.make({1});
  *tape.data(y) = upper.usable() ? static_cast<S>(upper.cost) : S(0);
  if (!upper.usable()) return y;
  const nn::Index count = tape.shape(z).size();
  expects(upper.gradient.size() == count, "imperative_loss: dU/dz must be as long as z");
  S* const slope = tape.template keep<S>(count);
  for (nn::Index i = 0; i < count; ++i) slope[i] = static_cast<S>(upper.gradient[i]);
  return tape.record(y, {z}, [y, z, slope, count](nn::Tape<S>& back) {
    const S dU = back.gradient(y)[0];
    back.accumulate(z, [&](nn::ArrayMap<S> dz) {
      for (nn::Index i = 0; i < count; ++i) dz[i] += slope[i] * dU;
    });
  });
}

#define INSTANTIATE(S)                                     \
  template Vector numbers_of(const nn::Tape<S>&, nn::Var); \
  template nn::Var imperative_loss(nn::Tape<S>&, nn::Var, const UpperGradient&);
INSTANTIATE(float)
INSTANTIATE(double)

}  // namespace imslam::learner
