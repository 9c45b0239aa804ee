#include "slam/nn/ops/normalise.hpp"

namespace imslam::nn {
namespace {

/// x as [samples, pixels, channels]; a set is one sample, all its pixels, channels / groups
/// channels.
struct Sets {
  Index samples;
  Index pixels;
  Index channels;
  Index groups;

  Index width() const { return channels / groups; }
  Index count() const { return pixels * width(); }  ///< numbers in a set
  Index set_of(Index sample, Index channel) const { return sample * groups + channel / width(); }
  Index offset(Index sample, Index pixel) const { return (sample * pixels + pixel) * channels; }
};

/// sums[set] = sum of term(offset, channel, set) over its numbers.
template <typename S, typename Term>
void sum_over_sets(const Sets& sets, Wide<S>* sums, const Term& term) {
  std::fill_n(sums, sets.samples * sets.groups, Wide<S>(0));
  for (Index n = 0; n < sets.samples; ++n) {
    for (Index p = 0; p < sets.pixels; ++p) {
      const Index row = sets.offset(n, p);
      for (Index g = 0; g < sets.groups; ++g) {
        Wide<S> sum(0);
        for (Index c = g * sets.width(); c < (g + 1) * sets.width(); ++c) {
          sum += Wide<S>(term(row + c, c, n * sets.groups + g));
        }
        sums[n * sets.groups + g] += sum;
      }
    }
  }
}

/// visit(offset, channel, set) for all numbers.
template <typename Visit>
void for_each_number(const Sets& sets, const Visit& visit) {
  for (Index n = 0; n < sets.samples; ++n) {
    for (Index p = 0; p < sets.pixels; ++p) {
      const Index row = sets.offset(n, p);
      for (Index g = 0; g < sets.groups; ++g) {
        for (Index c = g * sets.width(); c < (g + 1) * sets.width(); ++c) {
          visit(row + c, c, n * sets.groups + g);
        }
      }
    }
  }
}

template <typename S>
S inverse_deviation(const S& variance) {
  using std::sqrt;
  return S(1) / sqrt(variance + S(kNormEpsilon));
}

template <typename S>
void backward(
    Tape<S>& t, const Sets& sets, const BatchNormResult& result, Var x, Var gain, Var bias) {
  const Index count = sets.samples * sets.groups;
  Scratch<S> scratch(t);
  const S* const X = t.data(x);
  const S* const dY = t.gradient_data(result.y);
  const S* const m = t.data(result.mean);
  const S* const G = gain ? t.data(gain) : nullptr;
  S* const r = scratch.template array<S>(count);
  for (Index s = 0; s < count; ++s) r[s] = inverse_deviation(t.data(result.variance)[s]);
  const auto h = [&](Index i, Index set) { return (X[i] - m[set]) * r[set]; };
  const auto dh = [&](Index i, Index c) { return G == nullptr ? dY[i] : dY[i] * G[c]; };

  if (t.wants_gradient(x)) {
    Wide<S>* const sum_dh = scratch.template array<Wide<S>>(count);
    Wide<S>* const sum_dh_h = scratch.template array<Wide<S>>(count);
    sum_over_sets<S>(sets, sum_dh, [&](Index i, Index c, Index) { return dh(i, c); });
    sum_over_sets<S>(sets, sum_dh_h, [&](Index i, Index c, Index s) { return dh(i, c) * h(i, s); });
    S* const dX = t.gradient_data(x);
    const S share = S(1.0 / static_cast<double>(sets.count()));
    for_each_number(sets, [&](Index i, Index c, Index s) {
      dX[i] += r[s] * (dh(i, c) - share * S(sum_dh[s]) - h(i, s) * share * S(sum_dh_h[s]));
    });
  }
  Wide<S>* const sums = scratch.template zeros<Wide<S>>(2 * sets.channels);
  for_each_number(sets, [&](Index i, Index c, Index s) {
    sums[c] += Wide<S>(dY[i] * h(i, s));
    sums[sets.channels + c] += Wide<S>(dY[i]);
  });
  for (Index c = 0; c < sets.channels; ++c) {
    if (t.wants_gradient(gain)) t.gradient_data(gain)[c] += S(sums[c]);
    if (t.wants_gradient(bias)) t.gradient_data(bias)[c] += S(sums[sets.channels + c]);
  }
}

template <typename S>
void fill_statistics(Tape<S>& tape, const Sets& sets, Var x, Var mean, Var variance) {
  const Index count = sets.samples * sets.groups;
  Scratch<S> scratch(tape);
  Wide<S>* const sums = scratch.template array<Wide<S>>(count);
  const S* const X = tape.data(x);
  S* const m = tape.data(mean);
  S* const v = tape.data(variance);
  const Wide<S> share(1.0 / static_cast<double>(std::max<Index>(sets.count(), 1)));
  sum_over_sets<S>(sets, sums, [&](Index i, Index, Index) { return X[i]; });
  for (Index s = 0; s < count; ++s) m[s] = S(sums[s] * share);
  sum_over_sets<S>(sets, sums,
                   [&](Index i, Index, Index s) { return (X[i] - m[s]) * (X[i] - m[s]); });
  for (Index s = 0; s < count; ++s) v[s] = S(sums[s] * share);
}

template <typename S>
BatchNormResult normalise(Tape<S>& tape, const Sets& sets, Var x, Var gain, Var bias) {
  const Shape of_affine{sets.channels};
  expects_shapes(!gain || tape.shape(gain) == of_affine, "norm: gain [C]", of_affine,
                 gain ? tape.shape(gain) : of_affine);
  expects_shapes(!bias || tape.shape(bias) == of_affine, "norm: bias [C]", of_affine,
                 bias ? tape.shape(bias) : of_affine);
  const Index count = sets.samples * sets.groups;
  const BatchNormResult result{tape.make(tape.shape(x)), tape.make(Shape{count}),
                               tape.make(Shape{count})};
  fill_statistics(tape, sets, x, result.mean, result.variance);
  Scratch<S> scratch(tape);
  S* const r = scratch.template array<S>(count);
  for (Index s = 0; s < count; ++s) r[s] = inverse_deviation(tape.data(result.variance)[s]);
  const S* const X = tape.data(x);
  const S* const m = tape.data(result.mean);
  const S* const G = gain ? tape.data(gain) : nullptr;
  const S* const B = bias ? tape.data(bias) : nullptr;
  S* const Y = tape.data(result.y);
  for_each_number(sets, [&](Index i, Index c, Index s) {
    const S h = (X[i] - m[s]) * r[s];
    Y[i] = (G == nullptr ? h : G[c] * h) + (B == nullptr ? S(0) : B[c]);
  });
  return result;
}

template <typename S>
BatchNormResult record_norm(Tape<S>& tape, const Sets& sets, Var x, Var gain, Var bias) {
  const BatchNormResult result = normalise(tape, sets, x, gain, bias);
  tape.record(result.y, {x, gain, bias},
              [=](Tape<S>& t) { backward(t, sets, result, x, gain, bias); });
  return result;
}

}  // namespace

template <typename S>
Var layer_norm(Tape<S>& tape, Var x, Var gain, Var bias) {
  const Shape shape = tape.shape(x);
  return record_norm(tape, {shape.rows(), 1, shape.channels(), 1}, x, gain, bias).y;
}

template <typename S>
Var group_norm(Tape<S>& tape, Var x, Var gain, Var bias, int groups) {
  const Shape shape = tape.shape(x);
  expects_shape(shape.rank() >= 2 && groups >= 1 && shape.channels() % groups == 0,
                "group_norm: x [N,...,C] with C divisible by the groups", shape);
  const Index pixels = shape[0] == 0 ? 0 : shape.rows() / shape[0];
  return record_norm(tape, {shape[0], pixels, shape.channels(), groups}, x, gain, bias).y;
}

template <typename S>
Var instance_norm(Tape<S>& tape, Var x, Var gain, Var bias) {
  return group_norm(tape, x, gain, bias, static_cast<int>(tape.shape(x).channels()));
}

template <typename S>
BatchNormResult batch_norm(Tape<S>& tape, Var x, Var gain, Var bias) {
  const Shape shape = tape.shape(x);
  return record_norm(tape, {1, shape.rows(), shape.channels(), shape.channels()}, x, gain, bias);
}

template <typename S>
Var l2_normalise(Tape<S>& tape, Var x) {
  const Shape shape = tape.shape(x);
  const Var y = tape.make(shape);
  S* const inverse_length = tape.template keep<S>(shape.rows());
  const MatrixMap<S> X = tape.matrix(x);
  MatrixMap<S> Y = tape.matrix(y);
  for (Index r = 0; r < shape.rows(); ++r) {
    using std::sqrt;
    inverse_length[r] = S(1) / sqrt(X.row(r).squaredNorm() + S(1e-12));
    Y.row(r) = inverse_length[r] * X.row(r);
  }
  return tape.record(y, {x}, [=](Tape<S>& t) {
    const MatrixMap<S> unit = t.matrix(y);
    const MatrixMap<S> dY = t.gradient_matrix(y);
    MatrixMap<S> dX = t.gradient_matrix(x);
    for (Index r = 0; r < unit.rows(); ++r) {
      const S along = unit.row(r).dot(dY.row(r));
      dX.row(r) += inverse_length[r] * (dY.row(r) - along * unit.row(r));
    }
  });
}

#define INSTANTIATE(S)                                          \
  template Var layer_norm(Tape<S>&, Var, Var, Var);             \
  template Var group_norm(Tape<S>&, Var, Var, Var, int);        \
  template Var instance_norm(Tape<S>&, Var, Var, Var);          \
  template BatchNormResult batch_norm(Tape<S>&, Var, Var, Var); \
  template Var l2_normalise(Tape<S>&, Var);
IMSLAM_NN_FOR_EACH_SCALAR(INSTANTIATE)

}  // namespace imslam::nn
