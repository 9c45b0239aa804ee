#include "vo_net/match_network.hpp"

#include <cmath>

#include "slam/nn/ops/arithmetic.hpp"

namespace imslam::vo {
namespace {

using nn::Var;

constexpr double kLargestPrediction = 1e5;  // [px]

CellShift cells_of(const MatchHint& hint) {
  expects(std::abs(hint.predicted_x) < kLargestPrediction &&
              std::abs(hint.predicted_y) < kLargestPrediction,
          "MatchNetwork: the predicted displacement must be finite, in pixels");
  constexpr double kCell = CoarseMatcher<float>::kStride;
  return {static_cast<int>(std::lround(hint.predicted_x / kCell)),
          static_cast<int>(std::lround(hint.predicted_y / kCell))};
}

/// Rectified images: what a level says across the row is not believed.
template <typename S>
void keep_to_row(nn::Tape<S>& tape, LevelMatch& level) {
  const Var along_row = tape.make({2});
  tape.data(along_row)[0] = S(1);
  tape.data(along_row)[1] = S(0);
  level.displacement = multiply(tape, level.displacement, along_row);
}

const MatchNetworkOptions& validated(const MatchNetworkOptions& options) {
  options.validate();
  return options;
}

}  // namespace

template <typename S>
MatchBranch<S>::MatchBranch(const MatchNetworkOptions& options, MatchKind of, Random& random)
    : kind(of),
      coarse(options, kind, random),
      fine{FineMatcher<S>(options, 8), FineMatcher<S>(options, 4), FineMatcher<S>(options, 2)},
      head(options, kind, random) {}

template <typename S>
NetworkMatch MatchBranch<S>::forward(nn::Tape<S>& tape,
                                     const FeaturePyramid& features0,
                                     const FeaturePyramid& features1,
                                     Var points,
                                     const MatchHint& hint) {
  NetworkMatch result;
  LevelMatch& first = result.levels[0];
  first = coarse.forward(tape, features0.sixteenth, features1.sixteenth, points, cells_of(hint),
                         hint.coarse_logits);
  if (kind == MatchKind::kStereo) keep_to_row(tape, first);
  const std::array<Var, kFineLevels> f0{features0.eighth, features0.quarter, features0.half};
  const std::array<Var, kFineLevels> f1{features1.eighth, features1.quarter, features1.half};
  std::array<typename FineMatcher<S>::Match, kFineLevels> matches;
  for (std::size_t i = 0; i < kFineLevels; ++i) {
    const Var guess = hint.guess ? hint.guess : result.levels[i].displacement;
    matches[i] = fine[i].forward(tape, f0[i], f1[i], points, guess);
    if (kind == MatchKind::kStereo) keep_to_row(tape, matches[i].level);
    result.levels[i + 1] = matches[i].level;
  }
  result.prediction = head.forward(tape, first, matches);
  return result;
}

template <typename S>
void MatchBranch<S>::collect(nn::ParameterList<S>& list, const std::string& prefix) {
  coarse.collect(list, prefix + "coarse.");
  for (FineMatcher<S>& level : fine) {
    level.collect(list, prefix + "fine" + std::to_string(level.stride) + ".");
  }
  head.collect(list, prefix + "head.");
}

template <typename S>
MatchNetwork<S>::MatchNetwork(const MatchNetworkOptions& o, Random& random)
    : options(validated(o)),
      encoder(options, random),
      flow(options, MatchKind::kFlow, random),
      stereo(options, MatchKind::kStereo, random) {}

template <typename S>
FeaturePyramid MatchNetwork<S>::encode(nn::Tape<S>& tape, Var image) {
  return encoder.forward(tape, local_normalisation(tape, image, options.normalisation));
}

template <typename S>
NetworkMatch MatchNetwork<S>::forward(nn::Tape<S>& tape,
                                      const FeaturePyramid& features0,
                                      const FeaturePyramid& features1,
                                      Var points,
                                      MatchKind kind,
                                      const MatchHint& hint) {
  const nn::Shape shape = tape.shape(points);
  nn::expects_shapes(
      shape.rank() == 3 && shape[2] == 2 && shape[0] == tape.shape(features0.half)[0],
      "MatchNetwork::forward: points [N,P,2]", shape, tape.shape(features0.half));
  expects(tape.array(points).isFinite().all(), "MatchNetwork::forward: points must be finite");
  MatchBranch<S>& branch = kind == MatchKind::kFlow ? flow : stereo;
  return branch.forward(tape, features0, features1, points, hint);
}

template <typename S>
Var MatchNetwork<S>::coarse_logits(nn::Tape<S>& tape,
                                   const FeaturePyramid& features0,
                                   const FeaturePyramid& features1,
                                   MatchKind kind,
                                   const MatchHint& hint) {
  CoarseMatcher<S>& coarse = kind == MatchKind::kFlow ? flow.coarse : stereo.coarse;
  return coarse.logits(tape, features0.sixteenth, features1.sixteenth,
                       coarse.shifted_window(cells_of(hint)));
}

template <typename S>
void MatchNetwork<S>::collect(nn::ParameterList<S>& list, const std::string& prefix) {
  encoder.collect(list, prefix + "encoder.");
  flow.collect(list, prefix + "flow.");
  stereo.collect(list, prefix + "stereo.");
}

template <typename S>
void MatchNetwork<S>::fold() {
  encoder.fold();
  flow.coarse.fold();
  stereo.coarse.fold();
}

template <typename S>
void MatchNetwork<S>::freeze_norms(bool frozen) {
  encoder.freeze_norms(frozen);
  flow.coarse.freeze_norms(frozen);
  stereo.coarse.freeze_norms(frozen);
}

template struct MatchBranch<float>;
template struct MatchBranch<double>;
template struct MatchNetwork<float>;
template struct MatchNetwork<double>;

}  // namespace imslam::vo
