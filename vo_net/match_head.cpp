#include "vo_net/match_head.hpp"

#include "slam/nn/ops/activation.hpp"
#include "slam/nn/ops/arithmetic.hpp"
#include "slam/nn/ops/layout.hpp"
#include "slam/nn/ops/pointwise.hpp"
#include "slam/nn/ops/softmax.hpp"

namespace imslam::vo {
namespace {

using nn::Index;
using nn::Var;

constexpr Index kLevels = static_cast<Index>(kFineLevels) + 1;
constexpr double kResidualUnit = 2.0;  // [px], a cell of the finest level

/// Outputs: mixing (4), residual (D), log sigma (D), confidence (1), correlation (flow only: 1).
Index output_count(Index dimensions) {
  return kLevels + 2 * dimensions + 1 + (dimensions == 2 ? 1 : 0);
}

/// How far a level moves from the one before [N,P,D], in cells of that one.
template <typename S>
Var step(nn::Tape<S>& tape, const LevelMatch& from, const LevelMatch& to, Index dimensions) {
  const Var moved = subtract(tape, to.displacement, from.displacement);
  const Var cells = scale(tape, moved, 1.0 / from.stride);
  return tanh(tape, slice(tape, cells, -1, 0, dimensions));
}

/// floor + softplus(x - floor): about x, never below the floor, and never without a way back.
template <typename S>
Var bounded_below(nn::Tape<S>& tape, Var x, double floor) {
  return shift(tape, softplus(tape, shift(tape, x, -floor)), floor);
}

}  // namespace

template <typename S>
MatchHead<S>::MatchHead(const MatchNetworkOptions& o, MatchKind kind, Random& random)
    : dimensions(kind == MatchKind::kFlow ? 2 : 1) {
  const int fine_levels = static_cast<int>(kFineLevels);
  const int inputs = fine_levels * (o.fine_window().count() + dimensions) + 2 * (fine_levels + 1) +
                     o.eighth_channels;
  first = nn::Linear<S>(inputs, o.head_channels, random);
  second = nn::Linear<S>(o.head_channels, o.head_channels, random);
  output = nn::Linear<S>(o.head_channels, static_cast<int>(output_count(dimensions)), random);
  // Untrained: believe the fine levels rather than the coarse ones, change nothing.
  initialise_constant(output.weight, 0.0);
  for (Index level = 0; level < kLevels; ++level) output.bias.value[level] = static_cast<S>(level);
}

template <typename S>
MatchPrediction MatchHead<S>::forward(
    nn::Tape<S>& tape,
    const LevelMatch& coarse,
    const std::array<typename FineMatcher<S>::Match, kFineLevels>& fine) const {
  const Index D = dimensions;
  const Var seen = concat(
      tape,
      {fine[0].cosines, fine[1].cosines, fine[2].cosines, softmax_summary(tape, coarse.logits),
       softmax_summary(tape, fine[0].level.logits), softmax_summary(tape, fine[1].level.logits),
       softmax_summary(tape, fine[2].level.logits), step(tape, coarse, fine[0].level, D),
       step(tape, fine[0].level, fine[1].level, D), step(tape, fine[1].level, fine[2].level, D),
       fine[0].query},
      -1);
  const Var hidden = first.forward(tape, seen, nn::Activation::kRelu);
  const Var said = output.forward(tape, second.forward(tape, hidden, nn::Activation::kRelu));
  const auto part = [&](Index start, Index count) { return slice(tape, said, -1, start, count); };

  MatchPrediction prediction;
  prediction.mixing = softmax(tape, part(0, kLevels));
  prediction.displacement = scale(tape, part(kLevels, D), kResidualUnit);
  for (Index level = 0; level < kLevels; ++level) {
    const LevelMatch& match = level == 0 ? coarse : fine[static_cast<std::size_t>(level - 1)].level;
    const Var share = multiply(tape, slice(tape, prediction.mixing, -1, level, 1),
                               slice(tape, match.displacement, -1, 0, D));
    prediction.displacement = add(tape, prediction.displacement, share);
  }
  prediction.log_sigma = bounded_below(tape, part(kLevels + D, D), kLogSigmaFloor);
  const Var confidence = part(kLevels + 2 * D, 1);
  prediction.confidence = reshape(tape, confidence, tape.shape(confidence).without(-1));
  if (D == 2) {
    prediction.correlation =
        scale(tape, tanh(tape, part(kLevels + 2 * D + 1, 1)), kLargestCorrelation);
  }
  return prediction;
}

template <typename S>
void MatchHead<S>::collect(nn::ParameterList<S>& list, const std::string& prefix) {
  first.collect(list, prefix + "first.");
  second.collect(list, prefix + "second.");
  output.collect(list, prefix + "output.");
}

template struct MatchHead<float>;
template struct MatchHead<double>;

}  // namespace imslam::vo
