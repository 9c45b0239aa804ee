#pragma once

#include <string>

#include "slam/base/config.hpp"

namespace imslam::vo {

struct LearnedMatcherOptions {
  std::string weights;          ///< file; empty: the network that the program was shipped with
  int max_points = 900;         ///< about; at most one point per cell of a grid
  double min_confidence = 0.5;  ///< [1] that a match is right; less is none
  int max_width = 640;          ///< [px] wider images are shrunk to it before the network sees them
  int max_width_hard = 1400;    ///< [px] likewise in frames where Lucas-Kanade seldom helps
  double min_contrast = 0.5;    ///< [grey levels] around a point: less shows nothing

  bool polish = true;                   ///< Lucas-Kanade at full size, from the network's answer
  int coarse_polish = 2;                ///< halvings of the images, where full size does not help
  int polish_window = 0;                ///< [px] odd, <= 23; 0: by the image's width
  double max_polish_sigma = 3.0;        ///< [px] matches less certain than that stay as they are
  double max_polish_move = 3.0;         ///< [px] farther away is something else
  double min_polish_correlation = 0.7;  ///< [1] of a patch with its match
  double max_row_error = 2.0;           ///< [px] between left and right
  double smoothing = 0.8;               ///< [px] sigma of the Gaussian before Lucas-Kanade
  double sigma_floor = 0.05;            ///< [px] error of a match that nothing explains

  void describe(Config& config);
  void validate() const;  ///< Throws InputError naming key, value and bound.

  /// With the polish window that suits the width of an image [px], see KltOptions::for_width().
  LearnedMatcherOptions for_width(int width) const;
};

}  // namespace imslam::vo
