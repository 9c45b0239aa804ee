#pragma once

#include <array>
#include <string>
#include <vector>

#include "slam/nn/layers/linear.hpp"
#include "vo_net/fine_matcher.hpp"

namespace imslam::vo {

/// What the network says about each query point. D = 2 for flow (x, y), 1 for stereo (x).
///
/// The error is distributed as Student's t with 3 degrees of freedom whose scale matrix is
///   flow    [ sx^2  r sx sy ]        stereo   sx^2        s = e^log_sigma, r = correlation
///           [ r sx sy  sy^2 ]
/// so the covariance is 3 times that (nu / (nu - 2)).
struct MatchPrediction {
  nn::Var displacement;  ///< [N,P,D] [px]; stereo: x_right - x_left = -disparity
  nn::Var log_sigma;     ///< [N,P,D] log [px], above kLogSigmaFloor
  nn::Var correlation;   ///< [N,P,1] in (-1, 1); none for stereo
  nn::Var confidence;    ///< [N,P] logit of "visible and less than 2 px off"
  nn::Var mixing;        ///< [N,P,4] weights of the levels 1/16, 1/8, 1/4, 1/2; their sum is 1
};

inline constexpr double kLogSigmaFloor = -3.0;  ///< where the error is exactly 0 it would run away
inline constexpr double kLargestCorrelation = 0.95;
inline constexpr std::size_t kFineLevels = 3;  ///< 1/8, 1/4, 1/2

/// Judges what the levels say: whom to believe, what to add, how sure to be.
///
///   in    cosines of the fine windows, peak and entropy of softmax(logits) of each level,
///         differences between successive levels (tanh, in cells of the coarser), query at 1/8
///   mlp   two hidden layers with ReLU
///   out   displacement = sum_l mixing_l displacement_l + 2 px residual
template <typename S>
struct MatchHead {
  MatchHead() = default;
  MatchHead(const MatchNetworkOptions& options, MatchKind kind, Random& random);

  MatchPrediction forward(
      nn::Tape<S>& tape,
      const LevelMatch& coarse,
      const std::array<typename FineMatcher<S>::Match, kFineLevels>& fine) const;

  void collect(nn::ParameterList<S>& list, const std::string& prefix);

  int dimensions = 2;  ///< D
  nn::Linear<S> first;
  nn::Linear<S> second;
  nn::Linear<S> output;
};

}  // namespace imslam::vo
