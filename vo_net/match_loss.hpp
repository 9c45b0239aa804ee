#pragma once

#include <array>

#include "slam/base/config.hpp"
#include "vo_net/match_network.hpp"

namespace imslam::vo {

/// Where the query points really are. D = 2 for flow, 1 for stereo (x_right - x_left).
template <typename S>
struct MatchTruth {
  nn::Tensor<S> displacement;  ///< [N,P,D] [px]; may be anything where not valid
  nn::Tensor<S> valid;         ///< [N,P] 1: the truth is known, 0: the point counts for nothing
  nn::Tensor<S> visible;       ///< [N,P] 1: depicted in image 1, 0: occluded or outside
};

struct MatchLossOptions {
  double level_weight = 1.0;       ///< of the cross-entropy of each level
  double likelihood_weight = 1.0;  ///< of the displacement with its uncertainty
  double confidence_weight = 1.0;
  double confident_error = 2.0;  ///< [px] a match that far off is no match

  void describe(Config& config);
  void validate() const;  ///< Throws InputError naming key, value and bound.
};

/// Parts of the loss, one number each.
struct MatchLoss {
  nn::Var total;
  std::array<nn::Var, kFineLevels + 1> cross_entropy;  ///< 1/16, 1/8, 1/4, 1/2
  nn::Var likelihood;
  nn::Var confidence;
};

/// What training minimises:
///
///   cross-entropy of each level with the truth spread bilinearly over the four cells around it,
///       mean over valid, visible points whose truth lies in the level's window
///   negative log-likelihood of the error, Student's t with 3 degrees of freedom, with the
///   predicted
///       scale (2x2 for flow, 1-D for stereo), mean over valid, visible points
///   binary cross-entropy of the confidence with "visible and |error| < confident_error", mean over
///       valid points
///
/// A part without any point is 0.
template <typename S>
MatchLoss match_loss(nn::Tape<S>& tape,
                     const NetworkMatch& match,
                     const MatchTruth<S>& truth,
                     const MatchLossOptions& options = {});

}  // namespace imslam::vo
