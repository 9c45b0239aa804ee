#include "slam/nn/ops/softmax.hpp"

namespace imslam::nn {
namespace {

template <typename S>
void expect_mask(const Tape<S>& tape, Var x, Var mask) {
  const Shape of_x = tape.shape(x);
  expects_shape(of_x.rank() >= 1, "softmax: at least one axis", of_x);
  if (!mask) return;
  const Shape of_mask = tape.shape(mask);
  bool fits = of_mask.rank() >= 1 && of_mask.rank() <= of_x.rank();
  for (int back = 1; fits && back <= of_mask.rank(); ++back) fits = of_mask[-back] == of_x[-back];
  expects_shapes(fits, "softmax: the mask has the shape of the last axes", of_x, of_mask);
}

/// Row r of the mask; null: everything counts.
template <typename S>
const S* mask_row(const Tape<S>& tape, Var mask, Index r) {
  if (!mask) return nullptr;
  const Shape shape = tape.shape(mask);
  return tape.data(mask) + (r % shape.rows()) * shape.channels();
}

template <typename S>
bool counts(const S* mask, Index i) {
  return mask == nullptr || mask[i] != S(0);
}

/// sum_j e^{x_j} = e^largest sum, over the channels that count; sum = 0 if none does. Kept apart:
/// added to a large `largest`, the logarithm of the sum would lose its digits.
template <typename S>
struct ExpSum {
  S largest = S(0);
  S sum = S(0);
};

/// y_i = e^{x_i - largest}, 0 where masked.
template <typename S>
ExpSum<S> exponentials(const S* x, const S* mask, Index width, S* y) {
  ExpSum<S> result;
  bool any = false;
  for (Index i = 0; i < width; ++i) {
    if (!counts(mask, i)) continue;
    if (!any || x[i] > result.largest) result.largest = x[i];
    any = true;
  }
  // What is masked may be anything: its exponential must not overflow on the way.
  for (Index i = 0; i < width; ++i) y[i] = counts(mask, i) ? S(x[i] - result.largest) : S(0);
  Eigen::Map<Eigen::Array<S, Eigen::Dynamic, 1>> row(y, width);
  row = row.exp();
  for (Index i = 0; mask != nullptr && i < width; ++i) {
    if (!counts(mask, i)) y[i] = S(0);
  }
  result.sum = row.sum();
  return result;
}

/// Fills a new value of the shape of x row by row: write(X, mask, Y, sum), where Y holds the
/// exponentials.
template <typename S, typename Write>
Var from_exponentials(Tape<S>& tape, Var x, Var mask, const Write& write) {
  expect_mask(tape, x, mask);
  const Shape shape = tape.shape(x);
  const Index width = shape.channels();
  const Var y = tape.make(shape);
  for (Index r = 0; r < shape.rows(); ++r) {
    const S* const X = tape.data(x) + r * width;
    const S* const m = mask_row(tape, mask, r);
    S* const Y = tape.data(y) + r * width;
    write(X, m, Y, exponentials(X, m, width, Y));
  }
  return y;
}

}  // namespace

template <typename S>
Var softmax(Tape<S>& tape, Var x, Var mask) {
  const Index width = tape.shape(x).channels();
  const auto write = [width](const S*, const S* m, S* Y, const ExpSum<S>& total) {
    for (Index i = 0; i < width; ++i) Y[i] = counts(m, i) ? S(Y[i] / total.sum) : S(0);
  };
  const Var y = from_exponentials(tape, x, mask, write);
  return tape.record(y, {x}, [=](Tape<S>& t) {
    const MatrixMap<S> Y = t.matrix(y);
    const MatrixMap<S> dY = t.gradient_matrix(y);
    MatrixMap<S> dX = t.gradient_matrix(x);
    for (Index r = 0; r < Y.rows(); ++r) {
      const S mean = Y.row(r).dot(dY.row(r));
      dX.row(r).array() += Y.row(r).array() * (dY.row(r).array() - mean);
    }
  });
}

template <typename S>
Var log_softmax(Tape<S>& tape, Var x, Var mask) {
  using std::log;
  const Shape shape = tape.shape(x);
  const Index width = shape.channels();
  const auto write = [width](const S* X, const S* m, S* Y, const ExpSum<S>& total) {
    const S log_sum = log(total.sum);
    for (Index i = 0; i < width; ++i) {
      Y[i] = counts(m, i) ? S(X[i] - total.largest - log_sum) : S(kMaskedLogProbability);
    }
  };
  const Var y = from_exponentials(tape, x, mask, write);
  return tape.record(y, {x}, [=](Tape<S>& t) {
    using std::exp;
    for (Index r = 0; r < shape.rows(); ++r) {
      const S* const m = mask_row(t, mask, r);
      const S* const Y = t.data(y) + r * width;
      const S* const dY = t.gradient_data(y) + r * width;
      S* const dX = t.gradient_data(x) + r * width;
      S total(0);
      for (Index i = 0; i < width; ++i) {
        if (counts(m, i)) total += dY[i];
      }
      for (Index i = 0; i < width; ++i) {
        if (counts(m, i)) dX[i] += dY[i] - exp(Y[i]) * total;
      }
    }
  });
}

#define INSTANTIATE(S)                      \
  template Var softmax(Tape<S>&, Var, Var); \
  template Var log_softmax(Tape<S>&, Var, Var);
IMSLAM_NN_FOR_EACH_SCALAR(INSTANTIATE)

}  // namespace imslam::nn
