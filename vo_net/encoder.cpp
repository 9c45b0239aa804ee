#include "vo_net/encoder.hpp"

#include "slam/nn/ops/layout.hpp"
#include "slam/nn/ops/normalise.hpp"
#include "slam/nn/ops/resize.hpp"

namespace imslam::vo {
namespace {

template <typename S>
nn::Conv2d<S> pointwise(int inputs, int outputs, Random& random) {
  return {inputs, outputs, 1, nn::ConvolutionOptions::square(1, 0), random};
}

/// fine + up(1x1 coarse); the 1x1 comes first, where there are fewer pixels.
template <typename S>
nn::Var top_down(nn::Tape<S>& tape,
                 nn::Var fine,
                 nn::Var coarse,
                 const nn::Conv2d<S>& channels_to_fine) {
  return add_upsampled2(tape, fine, channels_to_fine.forward(tape, coarse));
}

}  // namespace

template <typename S>
FeaturePyramid sample_of(nn::Tape<S>& tape, const FeaturePyramid& pyramid, nn::Index sample) {
  const auto one = [&](nn::Var features) { return slice(tape, features, 0, sample, 1); };
  return {one(pyramid.half), one(pyramid.quarter), one(pyramid.eighth), one(pyramid.sixteenth)};
}

template <typename S>
Encoder<S>::Encoder(const MatchNetworkOptions& o, Random& random)
    : half_down(2, o.half_channels, {3, 2}, random),
      half(o.half_channels, o.half_channels, {}, random),
      quarter_down(o.half_channels, o.quarter_channels, {3, 2}, random),
      quarter(o.quarter_channels, 1, random),
      eighth_down(o.quarter_channels, o.eighth_channels, {3, 2}, random),
      eighth(o.eighth_channels, 1, random),
      eighth_dilated(o.eighth_channels, 2, random),
      sixteenth_down(o.eighth_channels, o.sixteenth_channels, {3, 2}, random),
      sixteenth(o.sixteenth_channels, 1, random),
      sixteenth_to_eighth(pointwise<S>(o.sixteenth_channels, o.eighth_channels, random)),
      eighth_to_quarter(pointwise<S>(o.eighth_channels, o.quarter_channels, random)),
      quarter_to_half(pointwise<S>(o.quarter_channels, o.half_channels, random)),
      half_output(pointwise<S>(o.half_channels, o.half_channels, random)),
      quarter_output(pointwise<S>(o.quarter_channels, o.quarter_channels, random)),
      eighth_output(pointwise<S>(o.eighth_channels, o.eighth_channels, random)),
      sixteenth_output(pointwise<S>(o.sixteenth_channels, o.sixteenth_features, random)) {}

template <typename S>
FeaturePyramid Encoder<S>::forward(nn::Tape<S>& tape, nn::Var normalised) {
  const nn::Shape shape = tape.shape(normalised);
  nn::expects_shape(shape.rank() == 4 && shape[3] == 2 && shape[1] >= 1 && shape[2] >= 1,
                    "Encoder::forward: normalised [N,H,W,2]", shape);
  const nn::Var c2 = half.forward(tape, half_down.forward(tape, normalised));
  const nn::Var c4 = quarter.forward(tape, quarter_down.forward(tape, c2));
  const nn::Var wide = eighth.forward(tape, eighth_down.forward(tape, c4));
  const nn::Var c8 = eighth_dilated.forward(tape, wide);
  const nn::Var c16 = sixteenth.forward(tape, sixteenth_down.forward(tape, c8));
  const nn::Var t8 = top_down(tape, c8, c16, sixteenth_to_eighth);
  const nn::Var t4 = top_down(tape, c4, t8, eighth_to_quarter);
  const nn::Var t2 = top_down(tape, c2, t4, quarter_to_half);
  return {l2_normalise(tape, half_output.forward(tape, t2)),
          l2_normalise(tape, quarter_output.forward(tape, t4)),
          l2_normalise(tape, eighth_output.forward(tape, t8)),
          l2_normalise(tape, sixteenth_output.forward(tape, c16))};
}

template <typename S>
void Encoder<S>::collect(nn::ParameterList<S>& list, const std::string& prefix) {
  half_down.collect(list, prefix + "half_down.");
  half.collect(list, prefix + "half.");
  quarter_down.collect(list, prefix + "quarter_down.");
  quarter.collect(list, prefix + "quarter.");
  eighth_down.collect(list, prefix + "eighth_down.");
  eighth.collect(list, prefix + "eighth.");
  eighth_dilated.collect(list, prefix + "eighth_dilated.");
  sixteenth_down.collect(list, prefix + "sixteenth_down.");
  sixteenth.collect(list, prefix + "sixteenth.");
  sixteenth_to_eighth.collect(list, prefix + "sixteenth_to_eighth.");
  eighth_to_quarter.collect(list, prefix + "eighth_to_quarter.");
  quarter_to_half.collect(list, prefix + "quarter_to_half.");
  half_output.collect(list, prefix + "half_output.");
  quarter_output.collect(list, prefix + "quarter_output.");
  eighth_output.collect(list, prefix + "eighth_output.");
  sixteenth_output.collect(list, prefix + "sixteenth_output.");
}

template <typename S>
std::array<ConvBlock<S>*, 9> Encoder<S>::blocks() {
  return {&half_down,      &half,         &quarter_down,         &quarter.block,
          &eighth_down,    &eighth.block, &eighth_dilated.block, &sixteenth_down,
          &sixteenth.block};
}

template <typename S>
void Encoder<S>::fold() {
  for (ConvBlock<S>* block : blocks()) block->fold();
}

template <typename S>
void Encoder<S>::freeze_norms(bool frozen) {
  for (ConvBlock<S>* block : blocks()) block->norm.frozen = frozen;
}

template struct Encoder<float>;
template struct Encoder<double>;
template FeaturePyramid sample_of(nn::Tape<float>&, const FeaturePyramid&, nn::Index);
template FeaturePyramid sample_of(nn::Tape<double>&, const FeaturePyramid&, nn::Index);

}  // namespace imslam::vo
