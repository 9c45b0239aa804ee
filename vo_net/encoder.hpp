#pragma once

#include <array>
#include <string>

#include "vo_net/conv_block.hpp"
#include "vo_net/match_options.hpp"

namespace imslam::vo {

/// What is remembered of an image: unit descriptors on four grids [N, ceil(H/s), ceil(W/s), C].
/// Cell (i, j) of the grid of stride s is centred on pixel (s j, s i).
struct FeaturePyramid {
  nn::Var half;
  nn::Var quarter;
  nn::Var eighth;
  nn::Var sixteenth;
};

/// Image `sample` of a pyramid of several.
template <typename S>
FeaturePyramid sample_of(nn::Tape<S>& tape, const FeaturePyramid& pyramid, nn::Index sample);

/// Features of an image, once per image whatever it is matched with.
///
///   down   1/2: conv s2, conv    1/4: conv s2, residual    1/8: conv s2, residual, residual
///   dilated 2    1/16: conv s2, residual
///   up     t_s = c_s + up(1x1 t_2s)        bilinear, cell centres aligned
///   out    f_s = 1x1 t_s / |1x1 t_s|
template <typename S>
struct Encoder {
  Encoder() = default;
  Encoder(const MatchNetworkOptions& options, Random& random);

  /// normalised [N,H,W,2], any size: see local_normalisation().
  FeaturePyramid forward(nn::Tape<S>& tape, nn::Var normalised);
  void collect(nn::ParameterList<S>& list, const std::string& prefix);
  void fold();  ///< norms into convolutions, for inference
  void freeze_norms(bool frozen);

  ConvBlock<S> half_down;
  ConvBlock<S> half;
  ConvBlock<S> quarter_down;
  ResidualBlock<S> quarter;
  ConvBlock<S> eighth_down;
  ResidualBlock<S> eighth;
  ResidualBlock<S> eighth_dilated;
  ConvBlock<S> sixteenth_down;
  ResidualBlock<S> sixteenth;

  nn::Conv2d<S> sixteenth_to_eighth;
  nn::Conv2d<S> eighth_to_quarter;
  nn::Conv2d<S> quarter_to_half;

  nn::Conv2d<S> half_output;
  nn::Conv2d<S> quarter_output;
  nn::Conv2d<S> eighth_output;
  nn::Conv2d<S> sixteenth_output;

 private:
  std::array<ConvBlock<S>*, 9> blocks();
};

}  // namespace imslam::vo
