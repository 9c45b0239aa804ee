#pragma once

#include <Eigen/Core>
#include <vector>

#include "slam/sensors/stereo.hpp"

namespace imslam::vo {

/// A grey image as floats at full, half, quarter, ... size, each with a mirrored border so that
/// patches may reach over the edge. Pixel (x, y) of level l is pixel (2x, 2y) of level l - 1.
class ImagePyramid {
 public:
  static constexpr int kBorder = 32;  ///< [px] on each side of each level

  struct Level {
    int width = 0;
    int height = 0;
    int stride = 0;                 ///< [floats] from row to row
    const float* pixels = nullptr;  ///< of (0, 0); valid from -kBorder to width + kBorder

    const float* at(int x, int y) const { return pixels + y * stride + x; }
  };

  ImagePyramid() = default;
  ImagePyramid(const ImagePyramid& other) { *this = other; }
  ImagePyramid& operator=(const ImagePyramid& other);
  ImagePyramid(ImagePyramid&&) = default;
  ImagePyramid& operator=(ImagePyramid&&) = default;
  ~ImagePyramid() = default;

  /// `smoothing` [px]: standard deviation of the Gaussian applied at full size, 0 for none.
  /// Buffers of earlier calls are used again. The image must not be empty.
  void build(const GrayImage& image, int levels, double smoothing);

  const std::vector<Level>& levels() const { return levels_; }
  const Level& operator[](int level) const { return levels_[static_cast<std::size_t>(level)]; }
  bool empty() const { return levels_.empty(); }

 private:
  std::vector<Level> levels_;
  std::vector<std::vector<float>> buffers_;
};

}  // namespace imslam::vo
