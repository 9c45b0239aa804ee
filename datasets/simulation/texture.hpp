#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

namespace imslam::simulation {

/// A square grey tile that repeats in both directions, with its mip-map pyramid.
///
/// Texture coordinates count tiles: (0, 0) and (1, 0) show the same texel.
class Texture {
 public:
  /// `size` is a power of two; `pixels` is row major, size * size.
  Texture(int size, std::vector<std::uint8_t> pixels);

  int size() const { return size_; }
  float mean() const { return static_cast<float>(pixels_.back()) / 255.0F; }
  /// Row major, finest level first; each has a quarter of the texels of the one before.
  const std::uint8_t* pixels() const { return pixels_.data(); }

 private:
  int size_ = 0;
  std::vector<std::uint8_t> pixels_;  ///< of all levels
};

}  // namespace imslam::simulation
