#include "vo_net/coarse_matcher.hpp"

#include <cmath>

#include "slam/nn/ops/arithmetic.hpp"
#include "slam/nn/ops/layout.hpp"
#include "slam/nn/ops/pointwise.hpp"
#include "slam/nn/ops/sampling.hpp"

namespace imslam::vo {
namespace {

constexpr double kFirstScale =
    10.0;  // of cosines: the best of 121 stands out, the others still learn

}  // namespace

template <typename S>
CoarseMatcher<S>::CoarseMatcher(const MatchNetworkOptions& o, MatchKind kind, Random& random)
    : window(o.coarse_window(kind)),
      sharpness(nn::Shape{1}),
      first(window.count() + o.sixteenth_features, o.decoder_channels, {}, random),
      second(o.decoder_channels, o.decoder_channels, {3, 1, 2}, random),
      third(o.decoder_channels, o.decoder_features, {}, random),
      correction(
          o.decoder_features, window.count(), 1, nn::ConvolutionOptions::square(1, 0), random) {
  initialise_constant(sharpness, std::log(kFirstScale));
  initialise_constant(correction.weight, 0.0);
}

template <typename S>
nn::Var CoarseMatcher<S>::logits(nn::Tape<S>& tape,
                                 nn::Var f0,
                                 nn::Var f1,
                                 const nn::Window& shifted) {
  const nn::Var cosines = cost_volume(tape, f0, f1, shifted);
  const nn::Var seen = first.forward(tape, concat(tape, {cosines, f0}, -1));
  const nn::Var aggregated = third.forward(tape, second.forward(tape, seen));
  const nn::Var scaled = multiply(tape, cosines, exp(tape, tape.parameter(sharpness)));
  return add(tape, scaled, correction.forward(tape, aggregated));
}

template <typename S>
LevelMatch CoarseMatcher<S>::forward(nn::Tape<S>& tape,
                                     nn::Var f0,
                                     nn::Var f1,
                                     nn::Var points,
                                     const CellShift& shift,
                                     nn::Var dense) {
  LevelMatch match;
  match.stride = kStride;
  match.window = shifted_window(shift);
  if (!dense) dense = logits(tape, f0, f1, match.window);
  const nn::Var places = scale(tape, points, 1.0 / kStride);
  match.logits = bilinear_sample(tape, dense, places, nn::Border::kClamp);
  match.origin = tape.make(tape.shape(points));
  tape.array(match.origin) = S(0);
  match.displacement = scale(tape, local_soft_argmax(tape, match.logits, match.window), kStride);
  return match;
}

template <typename S>
void CoarseMatcher<S>::collect(nn::ParameterList<S>& list, const std::string& prefix) {
  list.add(prefix + "sharpness", sharpness);
  first.collect(list, prefix + "first.");
  second.collect(list, prefix + "second.");
  third.collect(list, prefix + "third.");
  correction.collect(list, prefix + "correction.");
}

template <typename S>
void CoarseMatcher<S>::fold() {
  first.fold();
  second.fold();
  third.fold();
}

template <typename S>
void CoarseMatcher<S>::freeze_norms(bool frozen) {
  for (ConvBlock<S>* block : {&first, &second, &third}) block->norm.frozen = frozen;
}

template struct CoarseMatcher<float>;
template struct CoarseMatcher<double>;

}  // namespace imslam::vo
