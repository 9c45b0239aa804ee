#pragma once

#include <algorithm>

#include "slam/nn/tensor.hpp"
#include "slam/sensors/stereo.hpp"

namespace imslam::vo {

/// Means of squares of shrink x shrink pixels as the network takes them [height, width]; what is
/// left over at the right and below is cut off.
template <typename S>
void write_network_pixels(
    const GrayImage& image, int shrink, nn::Index height, nn::Index width, S* to) {
  if (shrink == 1) {
    std::transform(image.pixels.begin(), image.pixels.end(), to,
                   [](std::uint8_t pixel) { return static_cast<S>(pixel); });
    return;
  }
  const S share = S(1) / static_cast<S>(shrink * shrink);
  for (int i = 0; i < height; ++i) {
    for (int j = 0; j < width; ++j) {
      int sum = 0;
      for (int row = i * shrink; row < (i + 1) * shrink; ++row) {
        for (int column = j * shrink; column < (j + 1) * shrink; ++column) {
          sum += image.at(row, column);
        }
      }
      *to++ = static_cast<S>(sum) * share;
    }
  }
}

/// Centre of the network's pixel (0, 0) in pixels of the image.
inline double network_origin(int shrink) { return 0.5 * (shrink - 1); }

/// Variance over squared scale of the network's errors: nu / (nu - 2) of Student's t with nu = 3.
inline constexpr double kVarianceOfScale = 3.0;

}  // namespace imslam::vo
