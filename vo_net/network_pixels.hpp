#pragma once

#include <cstddef>
#include <cstdint>

#include "slam/nn/tensor.hpp"
#include "slam/sensors/stereo.hpp"

namespace imslam::vo {

/// Means of squares of shrink x shrink pixels [height, width]; kShrink is `shrink`, or 0 where the
/// compiler cannot know it.
template <int kShrink, typename S>
void write_means(const GrayImage& image, int shrink, nn::Index height, nn::Index width, S* to) {
  const int side = kShrink > 0 ? kShrink : shrink;
  const S share = S(1) / static_cast<S>(side * side);
  const std::uint8_t* row = image.pixels.data();
  for (nn::Index i = 0; i < height; ++i, row += std::ptrdiff_t{side} * image.width) {
    for (nn::Index j = 0; j < width; ++j) {
      const std::uint8_t* const corner = row + j * side;
      int sum = 0;
      for (int y = 0; y < side; ++y) {
        for (int x = 0; x < side; ++x) sum += corner[std::ptrdiff_t{y} * image.width + x];
      }
      to[i * width + j] = static_cast<S>(sum) * share;
    }
  }
}

/// The pixels as the network takes them [height, width]; what is left over at the right and below
/// is cut off.
template <typename S>
void write_network_pixels(
    const GrayImage& image, int shrink, nn::Index height, nn::Index width, S* to) {
  switch (shrink) {
    case 1:
      return write_means<1>(image, shrink, height, width, to);
    case 2:
      return write_means<2>(image, shrink, height, width, to);
    default:
      return write_means<0>(image, shrink, height, width, to);
  }
}

/// Centre of the network's pixel (0, 0) in pixels of the image.
inline double network_origin(int shrink) { return 0.5 * (shrink - 1); }

/// Variance over squared scale of the network's errors: nu / (nu - 2) of Student's t with nu = 3.
inline constexpr double kVarianceOfScale = 3.0;

}  // namespace imslam::vo
