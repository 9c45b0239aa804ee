#pragma once

#include "slam/base/config.hpp"
#include "slam/nn/ops/correlation.hpp"
#include "vo_net/local_normalisation.hpp"

namespace imslam::vo {

/// Which images are matched: two of one camera over time, or left and right of one time.
enum class MatchKind {
  kFlow,    ///< displacement (x, y)
  kStereo,  ///< displacement x = -disparity on the same row; y is 0 for rectified images
};

/// Sizes of the matching network. The defaults have about 0.85 million parameters.
struct MatchNetworkOptions {
  // Channels of the encoder at 1/2, 1/4, 1/8 and 1/16; the first three are those of the features.
  int half_channels = 16;
  int quarter_channels = 32;
  int eighth_channels = 64;
  int sixteenth_channels = 96;
  int sixteenth_features = 64;

  // Channels of the decoder of the coarse volume: two layers of the first, one of the second.
  int decoder_channels = 96;
  int decoder_features = 64;
  int head_channels = 64;  ///< of the two hidden layers of the head

  // Where is searched [cells of 16 px]; fine levels look at (2 fine_radius + 1)^2 cells of theirs.
  int flow_range = 5;          ///< to each side, from the predicted displacement
  int stereo_range_left = 12;  ///< disparities up to 192 px
  int stereo_range_right = 1;  ///< beyond infinity: errors of the rectification
  int stereo_range_vertical = 1;
  int fine_radius = 3;

  LocalNormalisationOptions normalisation;

  nn::Window coarse_window(MatchKind kind) const;
  nn::Window fine_window() const { return nn::Window::square(fine_radius); }

  void describe(Config& config);
  void validate() const;  ///< Throws InputError naming key, value and bound.
};

}  // namespace imslam::vo
