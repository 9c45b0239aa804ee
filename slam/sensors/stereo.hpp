#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <vector>

namespace imslam {

/// 8-bit grey image, row major, no padding. Empty (0 x 0) where the file was missing or damaged.
struct GrayImage {
  int width = 0;
  int height = 0;
  std::vector<std::uint8_t> pixels;

  bool empty() const { return pixels.empty(); }
  std::uint8_t at(int row, int column) const {
    return pixels[static_cast<std::size_t>(row) * static_cast<std::size_t>(width) +
                  static_cast<std::size_t>(column)];
  }
};

/// A rectified, undistorted pair taken at one instant. Either image may be empty: the frame still
/// has its place in time.
struct StereoFrame {
  std::size_t index = 0;  ///< position in the sequence
  std::int64_t time_ns = 0;
  GrayImage left;
  GrayImage right;
  /// Both images are good, but were not decoded: whoever needs them asks a FrameLoader.
  bool unread = false;

  bool complete() const { return unread || (!left.empty() && !right.empty()); }
};

/// Decodes the images of the frame at this position in the sequence.
using FrameLoader = std::function<StereoFrame(std::size_t index)>;

}  // namespace imslam
