#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "datasets/simulation/packet.hpp"
#include "datasets/simulation/texture.hpp"

namespace imslam::simulation {

/// Which textures the lanes of a packet look at; filled by TexturePool::aim().
struct TextureLanes {
  Ints size;        ///< [texels]
  Ints last_level;  ///< the coarsest
  Ints first;       ///< of the texture's entries in TexturePool::starts()
};

/// The pixels' footprints in their textures: a row of taps about (u, v).
struct Footprints {
  Floats u, v;    ///< of the middle [tiles]
  Floats du, dv;  ///< from one tap to the next [tiles]
  Floats lod;     ///< 0: the finest level, 1: texels twice as large
  Ints taps;      ///< at least 1
};

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

  /// Makes a lane look at a texture.
  void aim(std::size_t texture, std::size_t lane, TextureLanes& lanes) const {
    lanes.size[lane] = sizes_[texture];
    lanes.last_level[lane] = last_levels_[texture];
    lanes.first[lane] = static_cast<std::int32_t>(texture * kMostLevels);
  }

  /// Means over the taps, in [0, 1]; a tap is bilinear in its level and linear between levels.
  void sample(const TextureLanes& textures, const Footprints& footprints, Floats& means) const;

 private:
  std::vector<std::uint8_t> texels_;
  std::vector<std::int32_t> sizes_;
  std::vector<std::int32_t> last_levels_;
  std::vector<std::int32_t> starts_;
};

}  // namespace imslam::simulation
