#include "slam/nn/ops/dropout.hpp"

#include "slam/nn/ops/arithmetic.hpp"

namespace imslam::nn {

template <typename S>
Var dropout(Tape<S>& tape, Var x, double probability, Random& random) {
  expects(probability >= 0.0 && probability < 1.0, "dropout: probability in [0, 1)");
  if (!tape.training() || probability == 0.0) return x;
  const Var kept = tape.make(tape.shape(x));
  const S factor = S(1.0 / (1.0 - probability));
  for (Index i = 0; i < tape.shape(x).size(); ++i) {
    tape.data(kept)[i] = random.chance(probability) ? S(0) : factor;
  }
  return multiply(tape, x, kept);
}

#define INSTANTIATE(S) template Var dropout(Tape<S>&, Var, double, Random&);
IMSLAM_NN_FOR_EACH_SCALAR(INSTANTIATE)

}  // namespace imslam::nn
