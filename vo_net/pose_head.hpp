#pragma once

#include <array>
#include <string>
#include <vector>

#include "slam/base/random.hpp"
#include "slam/nn/layers/conv.hpp"
#include "slam/nn/layers/linear.hpp"
#include "slam/nn/tape.hpp"

namespace imslam::vo {

/// Sizes of the network. Those of the shipped weights are the defaults.
struct PoseHeadSizes {
  int fine = 24;    ///< channels at 1/2 of the grid
  int middle = 48;  ///< at 1/4
  int coarse = 64;  ///< at 1/8
  int hidden = 64;  ///< of the last layers
  int passes = 2;   ///< looks at the flow, each with the rotation found so far taken out
};

/// What one look says, absolute; N samples.
struct PoseHeadOutput {
  nn::Var rotation;             ///< [N,3] rotation vector of R_left0_left1 [rad]
  nn::Var direction;            ///< [N,3] of p_left0_left1, of length 1
  nn::Var log_sigma_rotation;   ///< [N,3] of each component [rad]
  nn::Var log_sigma_direction;  ///< [N,1] of each component across the direction [1]
};

/// x + conv(relu(conv(x))), then relu.
template <typename S>
struct FlowBlock {
  FlowBlock() = default;
  FlowBlock(int channels, Random& random);
  nn::Var forward(nn::Tape<S>& tape, nn::Var x) const;
  void collect(nn::ParameterList<S>& list, const std::string& prefix);

  nn::Conv2d<S> first, second;
};

/// Regression of the camera's motion from a flow grid (FlowGrid): rotation and direction of
/// translation, each with its uncertainty.
///
///   look k:   f = derotate(flow, theta_{k-1})     theta_0 = 0
///             m = median length of f              the unit of everything in this look
///             net([squash(f/m), confidence, x, y, products]) -> r, d, s
///             theta_k = Log(Exp(m r) Exp(theta_{k-1}))     direction = d / |d|
///             log sigma_rotation = log m + s_r    log sigma_direction = s_d
///
/// The unit replaces the fixed output scales of the published head: for small motions the answer
/// to k times the flow is the same direction and k times the rotation, whatever k. Taking the
/// rotation out and looking again leaves a flow of translation alone, whose unit is smaller.
/// The products x f, y f, conf. are given because a rotation's flow is bilinear in them.
template <typename S>
struct PoseHead {
  PoseHead(const PoseHeadSizes& sizes, Random& random);

  /// grids [N,H,W,5] as FlowGrid makes them (H, W as there); one output per look, the last one is
  /// the answer.
  std::vector<PoseHeadOutput> forward(nn::Tape<S>& tape, nn::Var grids) const;

  void collect(nn::ParameterList<S>& list, const std::string& prefix = "");

  PoseHeadSizes sizes;
  nn::Conv2d<S> to_fine, to_middle, to_coarse;
  FlowBlock<S> middle, coarse;
  nn::Linear<S> hidden, second, output;

 private:
  nn::Var look(nn::Tape<S>& tape, nn::Var flow, nn::Var confidence, nn::Var place) const;
};

}  // namespace imslam::vo
