#include "slam/nn/ops/reduce.hpp"

#include "slam/nn/ops/broadcast.hpp"
#include "slam/nn/ops/layout.hpp"
#include "slam/nn/ops/pointwise.hpp"

namespace imslam::nn {
namespace {

/// x with size 1 along the reduced axes.
Shape kept_shape(const Shape& x, std::initializer_list<int> axes) {
  Shape kept = x;
  for (const int axis : axes) kept = kept.with(axis, 1);
  return kept;
}

Shape dropped_shape(const Shape& x, std::initializer_list<int> axes) {
  std::array<Index, Shape::kMaxRank> sizes{};
  int rank = 0;
  for (int axis = 0; axis < x.rank(); ++axis) {
    bool reduced = false;
    for (const int a : axes) reduced = reduced || x.axis_of(a) == axis;
    if (!reduced) sizes[static_cast<std::size_t>(rank++)] = x[axis];
  }
  return {sizes.data(), rank};
}

/// visit(at_x, at_y): which number of x goes to which of y.
template <typename Visit>
void for_each_pair(const Shape& x, const Shape& kept, const Visit& visit) {
  const BroadcastLoop loop(x, x, kept);
  loop.for_each_row([&](Index, Index at_x, Index at_y) {
    for (Index i = 0; i < loop.length(); ++i) {
      visit(at_x + i * loop.step_a(), at_y + i * loop.step_b());
    }
  });
}

template <typename S>
Var dropped(Tape<S>& tape, Var y, const Shape& x, std::initializer_list<int> axes, Axes reduced) {
  return reduced == Axes::kKeep ? y : reshape(tape, y, dropped_shape(x, axes));
}

template <typename S>
Var sum_kept(Tape<S>& tape, Var x, const Shape& kept) {
  const Var y = tape.make(kept);
  const Shape of_x = tape.shape(x);
  Scratch<S> scratch(tape);
  Wide<S>* const sums = scratch.template zeros<Wide<S>>(kept.size());
  const S* const X = tape.data(x);
  for_each_pair(of_x, kept, [&](Index i, Index k) { sums[k] += Wide<S>(X[i]); });
  S* const Y = tape.data(y);
  for (Index k = 0; k < kept.size(); ++k) Y[k] = S(sums[k]);
  return y;
}

template <typename S>
Var record_sum(Tape<S>& tape, Var x, Var y) {
  return tape.record(y, {x}, [x, y](Tape<S>& t) {
    const S* const dY = t.gradient_data(y);
    S* const dX = t.gradient_data(x);
    for_each_pair(t.shape(x), t.shape(y), [&](Index i, Index k) { dX[i] += dY[k]; });
  });
}

template <typename S>
Var flat(Tape<S>& tape, Var x) {
  return reshape(tape, x, Shape{tape.shape(x).size()});
}

}  // namespace

template <typename S>
Var sum(Tape<S>& tape, Var x, std::initializer_list<int> axes, Axes reduced) {
  const Shape of_x = tape.shape(x);
  const Var y = record_sum(tape, x, sum_kept(tape, x, kept_shape(of_x, axes)));
  return dropped(tape, y, of_x, axes, reduced);
}

template <typename S>
Var mean(Tape<S>& tape, Var x, std::initializer_list<int> axes, Axes reduced) {
  const Var total = sum(tape, x, axes, reduced);
  const Index count = tape.shape(x).size() / std::max<Index>(tape.shape(total).size(), 1);
  expects_shape(count > 0, "mean: of at least one number", tape.shape(x));
  return scale(tape, total, 1.0 / static_cast<double>(count));
}

template <typename S>
Var maximum(Tape<S>& tape, Var x, std::initializer_list<int> axes, Axes reduced) {
  const Shape of_x = tape.shape(x);
  const Shape kept = kept_shape(of_x, axes);
  const bool nothing_to_do = kept.size() == 0;
  expects_shape(of_x.size() > 0 || nothing_to_do, "maximum: of at least one number", of_x);
  const Var y = tape.make(kept);
  Index* const from = tape.template keep<Index>(kept.size());
  std::fill_n(from, kept.size(), Index{-1});
  const S* const X = tape.data(x);
  for_each_pair(of_x, kept, [&](Index i, Index k) {
    if (from[k] < 0 || X[i] > X[from[k]]) from[k] = i;
  });
  S* const Y = tape.data(y);
  for (Index k = 0; k < kept.size(); ++k) Y[k] = X[from[k]];
  tape.record(y, {x}, [=](Tape<S>& t) {
    const S* const dY = t.gradient_data(y);
    S* const dX = t.gradient_data(x);
    for (Index k = 0; k < t.shape(y).size(); ++k) dX[from[k]] += dY[k];
  });
  return dropped(tape, y, of_x, axes, reduced);
}

template <typename S>
Var sum(Tape<S>& tape, Var x) {
  return sum(tape, flat(tape, x), {0});
}

template <typename S>
Var mean(Tape<S>& tape, Var x) {
  return mean(tape, flat(tape, x), {0});
}

template <typename S>
Var masked_mean(Tape<S>& tape, Var x, Var mask) {
  expects_shapes(tape.shape(x) == tape.shape(mask), "masked_mean: a mask of the same shape",
                 tape.shape(x), tape.shape(mask));
  const Var y = tape.make({});
  Wide<S> total(0);
  Wide<S> weight(0);
  const S* const X = tape.data(x);
  const S* const M = tape.data(mask);
  for (Index i = 0; i < tape.shape(x).size(); ++i) {
    // A masked number may be NaN or infinite.
    if (M[i] == S(0)) continue;
    total += Wide<S>(M[i]) * Wide<S>(X[i]);
    weight += Wide<S>(M[i]);
  }
  const S share = S(Wide<S>(1) / (weight > Wide<S>(1) ? weight : Wide<S>(1)));
  *tape.data(y) = S(total) * share;
  return tape.record(y, {x}, [=](Tape<S>& t) {
    t.accumulate(x, [&](ArrayMap<S> dX) { dX += t.array(mask) * (share * *t.gradient_data(y)); });
  });
}

#define INSTANTIATE(S)                                                   \
  template Var sum(Tape<S>&, Var, std::initializer_list<int>, Axes);     \
  template Var mean(Tape<S>&, Var, std::initializer_list<int>, Axes);    \
  template Var maximum(Tape<S>&, Var, std::initializer_list<int>, Axes); \
  template Var sum(Tape<S>&, Var);                                       \
  template Var mean(Tape<S>&, Var);                                      \
  template Var masked_mean(Tape<S>&, Var, Var);
IMSLAM_NN_FOR_EACH_SCALAR(INSTANTIATE)

}  // namespace imslam::nn
