#pragma once

#include <cstdint>

#include "slam/base/config.hpp"
#include "slam/base/random.hpp"
#include "slam/nn/tensor.hpp"
#include "slam/training/triplet.hpp"
#include "vo_net/match_loss.hpp"
#include "vo_net/match_network.hpp"

namespace imslam::training {

/// How the matching network is asked about a triplet.
struct QueryOptions {
  int points = 256;                ///< per triplet
  double textured_share = 0.5;     ///< of the points: the most textured of a few random places
  double fractional_share = 0.5;   ///< of the points: between pixels
  double hint_share = 0.5;         ///< of the triplets: the search is told where to look
  double hint_error = 12.0;        ///< [px] sigma of what it is told, per axis
  double least_guess_error = 0.5;  ///< [px] of the windows' places under teacher forcing,
  double most_guess_error = 6.0;   ///<      drawn between the two for each point

  void describe(Config& config);
  void validate() const;
};

/// A triplet as the network and its loss read it: P points of left0.
struct MatchSample {
  nn::Tensor<float> images;  ///< [3,H,W,1]: left0, right0, left1
  nn::Tensor<float> points;  ///< [1,P,2]
  vo::MatchTruth<float> flow;
  vo::MatchTruth<float> stereo;

  double predicted_x = 0.0;  ///< [px] where the flow's search is centred
  double predicted_y = 0.0;
  nn::Tensor<float> flow_guess;    ///< [1,P,2] truth with errors, for teacher forcing
  nn::Tensor<float> stereo_guess;  ///< [1,P,2]
};

/// Draws points and hints. Depends on its arguments only.
MatchSample draw_queries(const Triplet& triplet, const QueryOptions& options, Random random);

/// The matches of one kind. `teacher`: fine levels look where the truth is, more or less, instead
/// of where the level before says.
vo::NetworkMatch match_sample(nn::Tape<float>& tape,
                              vo::MatchNetwork<float>& network,
                              const vo::FeaturePyramid& features,
                              const MatchSample& sample,
                              vo::MatchKind kind,
                              bool teacher);

}  // namespace imslam::training
