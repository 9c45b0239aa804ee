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

  /// Radiance in [0, 1], bilinear within and linear between levels; lod 0 is the finest level.
  float sample(float u, float v, float lod) const;

  int size() const { return size_; }
  float mean() const { return static_cast<float>(pixels_.back()) / 255.0F; }
  const std::uint8_t* pixels() const { return pixels_.data(); }  ///< of the finest level

 private:
  float bilinear(std::size_t level, float u, float v) const;

  int size_ = 0;
  std::vector<std::uint8_t> pixels_;  ///< all levels, finest first
  std::vector<std::size_t> offsets_;  ///< of each level in pixels_
};

}  // namespace imslam::simulation
