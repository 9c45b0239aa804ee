#include <algorithm>
#include <cmath>

#include "slam/nn/ops/softmax.hpp"

namespace imslam::nn {
namespace {

template <typename S>
using Row = Eigen::Map<Eigen::Array<S, Eigen::Dynamic, 1>>;
template <typename S>
using ConstRow = Eigen::Map<const Eigen::Array<S, Eigen::Dynamic, 1>>;

/// Of one row; `shifted` takes x - max x, `exps` its exponentials.
template <typename S>
struct Summary {
  S sum;      ///< of the exponentials, the largest of which is 1
  S entropy;  ///< log sum - <exps, shifted> / sum

  Summary(const ConstRow<S>& x, Row<S> shifted, Row<S> exps) {
    using std::log;
    shifted = x - x.maxCoeff();
    exps = shifted.exp();
    sum = exps.sum();
    entropy = log(sum) - (exps * shifted).sum() / sum;
  }
};

}  // namespace

template <typename S>
Var softmax_summary(Tape<S>& tape, Var x) {
  const Shape shape = tape.shape(x);
  const Index width = shape.channels();
  expects_shape(shape.rank() >= 1 && width >= 1, "softmax_summary: at least one channel", shape);
  const Var y = tape.make(shape.with_channels(2));
  {
    Scratch<S> scratch(tape);
    const Row<S> shifted(scratch.template zeros<S>(width), width);
    const Row<S> exps(scratch.template zeros<S>(width), width);
    for (Index r = 0; r < shape.rows(); ++r) {
      const Summary<S> summary(ConstRow<S>(tape.data(x) + r * width, width), shifted, exps);
      tape.data(y)[2 * r] = S(1) / summary.sum;
      tape.data(y)[2 * r + 1] = summary.entropy;
    }
  }
  return tape.record(y, {x}, [=](Tape<S>& t) {
    using std::log;
    Scratch<S> memory(t);
    Row<S> logs(memory.template zeros<S>(width), width);
    Row<S> p(memory.template zeros<S>(width), width);
    for (Index r = 0; r < shape.rows(); ++r) {
      const S* const X = t.data(x) + r * width;
      const Summary<S> summary(ConstRow<S>(X, width), logs, p);
      const S* const dy = t.gradient_data(y) + 2 * r;
      const Index best = std::max_element(X, X + width) - X;
      logs -= log(summary.sum);
      p /= summary.sum;
      Row<S> dx(t.gradient_data(x) + r * width, width);
      dx -= p * (dy[0] * p[best] + dy[1] * (logs + summary.entropy));
      dx[best] += dy[0] * p[best];
    }
  });
}

#define INSTANTIATE(S) template Var softmax_summary(Tape<S>&, Var);
IMSLAM_NN_FOR_EACH_SCALAR(INSTANTIATE)

}  // namespace imslam::nn
