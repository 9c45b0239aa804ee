#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "datasets/simulation/texture.hpp"

namespace imslam::simulation {

/// The texels of all textures and levels in one array, to be addressed by lanes that look at
/// different textures. The first row and column of each level are repeated behind the last, so
/// the four texels about a point are two pairs of neighbours.
class TexturePool {
 public:
  static constexpr std::size_t kMostLevels = 16;

  explicit TexturePool(const std::vector<Texture>& textures);

  const std::uint8_t* texels() const { return texels_.data(); }
  std::int32_t size(std::size_t texture) const { return sizes_[texture]; }
  std::int32_t last_level(std::size_t texture) const { return last_levels_[texture]; }
  /// Where each texture's levels start, kMostLevels entries per texture.
  const std::int32_t* starts() const { return starts_.data(); }

 private:
  std::vector<std::uint8_t> texels_;
  std::vector<std::int32_t> sizes_;
  std::vector<std::int32_t> last_levels_;
  std::vector<std::int32_t> starts_;
};

}  // namespace imslam::simulation
