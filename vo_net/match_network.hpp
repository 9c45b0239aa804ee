#pragma once

#include <array>
#include <string>

#include "vo_net/coarse_matcher.hpp"
#include "vo_net/encoder.hpp"
#include "vo_net/match_head.hpp"

namespace imslam::vo {

/// What is known before looking.
struct MatchHint {
  // Where the coarse search is centred [px], e.g. the mean displacement that gyro and last velocity
  // foretell; rounded to whole cells. Not a measurement: it only moves the window.
  double predicted_x = 0.0;
  double predicted_y = 0.0;
  /// Where the fine windows stand instead of on the answer of the level before: [N,P,2]
  /// displacements [px] or none. Teacher forcing gives the truth and some noise.
  nn::Var guess;
  /// What MatchNetwork::coarse_logits() made of the same features, or none: it is made then.
  nn::Var coarse_logits;
};

struct NetworkMatch {
  std::array<LevelMatch, kFineLevels + 1> levels;  ///< 1/16, 1/8, 1/4, 1/2
  MatchPrediction prediction;
};

/// The matching of one kind, coarse to fine.
template <typename S>
struct MatchBranch {
  MatchBranch() = default;
  MatchBranch(const MatchNetworkOptions& options, MatchKind kind, Random& random);

  NetworkMatch forward(nn::Tape<S>& tape,
                       const FeaturePyramid& features0,
                       const FeaturePyramid& features1,
                       nn::Var points,
                       const MatchHint& hint);
  void collect(nn::ParameterList<S>& list, const std::string& prefix);

  MatchKind kind = MatchKind::kFlow;
  CoarseMatcher<S> coarse;
  std::array<FineMatcher<S>, kFineLevels> fine;  ///< 1/8, 1/4, 1/2
  MatchHead<S> head;
};

/// Finds query points of one image in another.
///
///   images --local normalisation, encoder--> features, once per image
///   features0, features1, points --coarse, fine, head--> displacements, uncertainty, confidence
///
///   MatchNetwork<float> network(options, random);
///   const FeaturePyramid left0 = network.encode(tape, image);        // [N,H,W,1]
///   const NetworkMatch flow = network.forward(tape, left0, left1, points, MatchKind::kFlow);
///
/// Images that are matched have one size. Several images of a scene are best encoded together
/// (N > 1, then sample_of()): while training they then share the statistics of the norms.
template <typename S>
struct MatchNetwork {
  explicit MatchNetwork(const MatchNetworkOptions& options, Random& random);

  /// image [N,H,W,1] in grey levels of 255, any size from 1 x 1 on
  FeaturePyramid encode(nn::Tape<S>& tape, nn::Var image);

  /// points [N,P,2] (x, y) [px of image 0], pixel centres at whole numbers, finite; P may be 0
  NetworkMatch forward(nn::Tape<S>& tape,
                       const FeaturePyramid& features0,
                       const FeaturePyramid& features1,
                       nn::Var points,
                       MatchKind kind,
                       const MatchHint& hint = {});

  /// The part of the matching that does not depend on the points, for a hint of the same
  /// prediction.
  nn::Var coarse_logits(nn::Tape<S>& tape,
                        const FeaturePyramid& features0,
                        const FeaturePyramid& features1,
                        MatchKind kind,
                        const MatchHint& hint = {});

  /// All parameters: "encoder.half.conv.weight", "flow.coarse.sharpness", "stereo.head.first.bias".
  void collect(nn::ParameterList<S>& list, const std::string& prefix = "");

  /// Puts the norms into the convolutions: faster inference with the same numbers. For a network
  /// that will not be trained or saved any more.
  void fold();

  /// True: the norms use their running statistics while training too (fine-tuning).
  void freeze_norms(bool frozen);

  MatchNetworkOptions options;
  Encoder<S> encoder;
  MatchBranch<S> flow;
  MatchBranch<S> stereo;
};

}  // namespace imslam::vo
