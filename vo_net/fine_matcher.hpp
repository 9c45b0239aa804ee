#pragma once

#include <string>

#include "vo_net/level_match.hpp"
#include "vo_net/match_options.hpp"

namespace imslam::vo {

/// One level of refinement: a window of whole cells of image 1 around where the point is thought to
/// be.
///
///   q = f0(p / s) / |f0(p / s)|                 read between the cells
///   m = round((p + guess) / s)                  the cell in the middle
///   c_d = <q, f1(m + d)>                        0 outside of the image
///   logits = e^sharpness c        origin = s m - p
///
/// No gradient reaches the guess: each level learns to be right from where it stands.
template <typename S>
struct FineMatcher {
  struct Match {
    LevelMatch level;
    nn::Var cosines;  ///< c [N,P,K]
    nn::Var query;    ///< q [N,P,C]
  };

  FineMatcher() = default;
  FineMatcher(const MatchNetworkOptions& options, int stride);

  /// f0, f1 [N,h,w,C] unit features, points and guess [N,P,2] (x, y) [px]
  Match forward(nn::Tape<S>& tape, nn::Var f0, nn::Var f1, nn::Var points, nn::Var guess) const;

  void collect(nn::ParameterList<S>& list, const std::string& prefix) {
    list.add(prefix + "sharpness", sharpness);
  }

  int stride = 1;
  nn::Window window;
  nn::Parameter<S> sharpness;  ///< [1]
};

}  // namespace imslam::vo
