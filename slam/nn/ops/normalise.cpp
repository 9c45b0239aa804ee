#include "slam/nn/ops/normalise.hpp"

#include <algorithm>

#include "slam/nn/kernels/instruction_set.hpp"

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
};

/// One number per channel; all passes run along channels, which are contiguous.
template <typename S>
using Channels = Eigen::Map<Eigen::Array<S, 1, Eigen::Dynamic>, Eigen::Aligned64>;

template <typename S>
Channels<S> channels_of(Scratch<S>& scratch, const Sets& sets) {
  return {scratch.template zeros<S>(sets.channels), sets.channels};
}

/// Pixel p of sample n.
template <typename S>
Eigen::Map<Eigen::Array<S, 1, Eigen::Dynamic>> pixel(S* x, const Sets& sets, Index n, Index p) {
  return {x + (n * sets.pixels + p) * sets.channels, sets.channels};
}

constexpr float kSmallestSquare = 1e-12F;  // of a row's length: 0 has no direction
constexpr Index kPixelsPerSum = 64;        // short sums of floats, long ones of doubles

/// Sums over the pixels of a sample: add(p, partial) adds what pixel p gives.
template <typename S, typename Add>
void sum_pixels(const Sets& sets, Channels<S> partial, Channels<Wide<S>> sums, const Add& add) {
  sums = Wide<S>(0);
  for (Index first = 0; first < sets.pixels; first += kPixelsPerSum) {
    partial = S(0);
    for (Index p = first; p < std::min(first + kPixelsPerSum, sets.pixels); ++p) add(p, partial);
    sums += partial.template cast<Wide<S>>();
  }
}

/// The mean over the sets of sample n from its sums per channel.
template <typename S>
void mean_of_sets(const Sets& sets, Channels<Wide<S>> sums, S* means) {
  const Wide<S> share(1.0 / static_cast<double>(std::max<Index>(sets.count(), 1)));
  for (Index g = 0; g < sets.groups; ++g) {
    means[g] = S(sums.segment(g * sets.width(), sets.width()).sum() * share);
  }
}

/// Each set's number for all of its channels.
template <typename S>
void spread(const Sets& sets, const S* per_set, Channels<S> per_channel) {
  for (Index c = 0; c < sets.channels; ++c) per_channel[c] = per_set[c / sets.width()];
}

template <typename S>
void inverse_deviations(const Sets& sets, const S* variances, Channels<S> per_channel) {
  spread(sets, variances, per_channel);
  per_channel = (per_channel + S(kNormEpsilon)).sqrt().inverse();
}

/// gain, or ones.
template <typename S>
void fill_gain(const Tape<S>& tape, Var gain, Channels<S> per_channel) {
  if (gain) {
    std::copy_n(tape.data(gain), per_channel.size(), per_channel.data());
  } else {
    per_channel = S(1);
  }
}

template <typename S>
void backward(
    Tape<S>& t, const Sets& sets, const BatchNormResult& result, Var x, Var gain, Var bias) {
  Scratch<S> scratch(t);
  Channels<S> m = channels_of(scratch, sets);
  Channels<S> r = channels_of(scratch, sets);
  Channels<S> g = channels_of(scratch, sets);
  Channels<S> partial = channels_of(scratch, sets);
  Channels<S> mean_dh = channels_of(scratch, sets);
  Channels<S> mean_dh_h = channels_of(scratch, sets);
  S* const per_set = scratch.template zeros<S>(sets.groups);
  Channels<Wide<S>> sums(scratch.template zeros<Wide<S>>(sets.channels), sets.channels);
  fill_gain(t, gain, g);
  S* const X = t.data(x);
  S* const dY = t.gradient_data(result.y);
  for (Index n = 0; n < sets.samples; ++n) {
    spread<S>(sets, t.data(result.mean) + n * sets.groups, m);
    inverse_deviations<S>(sets, t.data(result.variance) + n * sets.groups, r);
    const auto take_means = [&](Var affine, Channels<S> means) {
      if (t.wants_gradient(affine)) t.gradient_matrix(affine).array() += sums.template cast<S>();
      sums *= g.template cast<Wide<S>>();
      mean_of_sets<S>(sets, sums, per_set);
      spread<S>(sets, per_set, means);
    };
    sum_pixels<S>(sets, partial, sums,
                  [&](Index p, Channels<S>& sum) { sum += pixel(dY, sets, n, p); });
    take_means(bias, mean_dh);
    sum_pixels<S>(sets, partial, sums, [&](Index p, Channels<S>& sum) {
      sum += pixel(dY, sets, n, p) * (pixel(X, sets, n, p) - m) * r;
    });
    take_means(gain, mean_dh_h);
    if (!t.wants_gradient(x)) continue;
    S* const dX = t.gradient_data(x);
    for (Index p = 0; p < sets.pixels; ++p) {
      pixel(dX, sets, n, p) +=
          r * (pixel(dY, sets, n, p) * g - mean_dh - (pixel(X, sets, n, p) - m) * r * mean_dh_h);
    }
  }
}

template <typename S>
BatchNormResult normalise(Tape<S>& tape, const Sets& sets, Var x, Var gain, Var bias) {
  const Index count = sets.samples * sets.groups;
  const BatchNormResult result{tape.make(tape.shape(x)), tape.make(Shape{count}),
                               tape.make(Shape{count})};
  Scratch<S> scratch(tape);
  Channels<S> m = channels_of(scratch, sets);
  Channels<S> r = channels_of(scratch, sets);
  Channels<S> g = channels_of(scratch, sets);
  Channels<S> b = channels_of(scratch, sets);
  Channels<S> partial = channels_of(scratch, sets);
  Channels<Wide<S>> sums(scratch.template zeros<Wide<S>>(sets.channels), sets.channels);
  fill_gain(tape, gain, g);
  if (bias) std::copy_n(tape.data(bias), sets.channels, b.data());
  S* const X = tape.data(x);
  S* const Y = tape.data(result.y);
  for (Index n = 0; n < sets.samples; ++n) {
    S* const mean = tape.data(result.mean) + n * sets.groups;
    S* const variance = tape.data(result.variance) + n * sets.groups;
    sum_pixels<S>(sets, partial, sums,
                  [&](Index p, Channels<S>& sum) { sum += pixel(X, sets, n, p); });
    mean_of_sets<S>(sets, sums, mean);
    spread<S>(sets, mean, m);
    sum_pixels<S>(sets, partial, sums,
                  [&](Index p, Channels<S>& sum) { sum += (pixel(X, sets, n, p) - m).square(); });
    mean_of_sets<S>(sets, sums, variance);
    inverse_deviations<S>(sets, variance, r);
    for (Index p = 0; p < sets.pixels; ++p) {
      pixel(Y, sets, n, p) = (pixel(X, sets, n, p) - m) * r * g + b;
    }
  }
  return result;
}

void expect_affine(const Shape& actual, Index channels) {
  expects_shapes(actual == Shape{channels}, "norm: gain and bias [C]", actual, {channels});
}

template <typename S>
BatchNormResult record_norm(Tape<S>& tape, const Sets& sets, Var x, Var gain, Var bias) {
  if (gain) expect_affine(tape.shape(gain), sets.channels);
  if (bias) expect_affine(tape.shape(bias), sets.channels);
  const BatchNormResult result = normalise(tape, sets, x, gain, bias);
  tape.record(result.y, {x, gain, bias},
              [=](Tape<S>& t) { backward(t, sets, result, x, gain, bias); });
  return result;
}

template <typename S>
void unit_rows(const MatrixMap<S>& X, S* inverse_length, MatrixMap<S> Y) {
  using std::sqrt;
  for (Index r = 0; r < X.rows(); ++r) {
    inverse_length[r] = S(1) / sqrt(X.row(r).squaredNorm() + S(kSmallestSquare));
    Y.row(r) = inverse_length[r] * X.row(r);
  }
}

void unit_rows(const MatrixMap<float>& X, float* inverse_length, MatrixMap<float> Y) {
  kernels::selected_kernels().unit_rows(X.data(), X.rows(), static_cast<int>(X.cols()),
                                        kSmallestSquare, inverse_length, Y.data());
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
  unit_rows(tape.matrix(x), inverse_length, tape.matrix(y));
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
