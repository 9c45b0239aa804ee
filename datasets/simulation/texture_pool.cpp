#include "datasets/simulation/texture_pool.hpp"

#include <limits>

#include "slam/base/error.hpp"

namespace imslam::simulation {

TexturePool::TexturePool(const std::vector<Texture>& textures) {
  for (const Texture& texture : textures) {
    const std::uint8_t* level = texture.pixels();
    std::size_t depth = 0;
    sizes_.push_back(texture.size());
    starts_.resize(starts_.size() + kMostLevels, 0);
    for (auto size = static_cast<std::size_t>(texture.size()); size > 0; size /= 2, ++depth) {
      expects(depth < kMostLevels, "TexturePool: texture too large");
      starts_[starts_.size() - kMostLevels + depth] = static_cast<std::int32_t>(texels_.size());
      for (std::size_t row = 0; row <= size; ++row) {
        const std::uint8_t* first = level + (row % size) * size;
        texels_.insert(texels_.end(), first, first + size);
        texels_.push_back(first[0]);
      }
      level += size * size;
    }
    last_levels_.push_back(static_cast<std::int32_t>(depth) - 1);
  }
  expects(texels_.size() < std::numeric_limits<std::int32_t>::max(),
          "TexturePool: too many textures");
}

}  // namespace imslam::simulation
