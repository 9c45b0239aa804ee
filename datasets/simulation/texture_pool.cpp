#include "datasets/simulation/texture_pool.hpp"

#include <algorithm>
#include <limits>

#include "datasets/simulation/lanes.hpp"
#include "slam/base/error.hpp"

// Vectors are passed by reference only, so their calling convention does not matter.
#pragma GCC diagnostic ignored "-Wpsabi"

namespace imslam::simulation {
namespace {

constexpr int kWeightBits = 10;  ///< of bilinear weights: 1/1024 texel
constexpr int kOne = 1 << kWeightBits;

/// A texel and its right neighbour, in the low and the high byte.
[[gnu::always_inline]] inline Ints pairs_at(const std::uint8_t* texels, const Ints& index) {
  Ints pairs;
  for (std::size_t i = 0; i < kLanes; ++i) {
    std::uint16_t pair;
    std::memcpy(&pair, texels + index[i], sizeof pair);
    pairs[i] = pair;
  }
  return pairs;
}

/// `start`: of the levels in `texels`; `size` of the levels, powers of two.
[[gnu::always_inline]] inline Floats bilinear(const std::uint8_t* texels,
                                              const Ints& start,
                                              const Ints& size,
                                              const Floats& u,
                                              const Floats& v) {
  const Floats scale = to_floats(size << kWeightBits);
  const Ints x = floor_to_ints(u * scale) - kOne / 2;  // texel centres lie at half integers
  const Ints y = floor_to_ints(v * scale) - kOne / 2;
  const Ints fx = x & (kOne - 1);
  const Ints fy = y & (kOne - 1);
  const Ints column = (x >> kWeightBits) & (size - 1);
  const Ints row = (y >> kWeightBits) & (size - 1);
  const Ints upper = start + row * (size + 1) + column;
  const Ints above = pairs_at(texels, upper);
  const Ints below = pairs_at(texels, upper + size + 1);
  const Ints top = (above & 255) * (kOne - fx) + (above >> 8) * fx;
  const Ints bottom = (below & 255) * (kOne - fx) + (below >> 8) * fx;
  constexpr float kUnit = 1.0F / (255.0F * kOne * kOne);
  return to_floats(top * (kOne - fy) + bottom * fy) * kUnit;
}

}  // namespace

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

IMSLAM_FOR_EACH_PROCESSOR void TexturePool::sample(const TextureLanes& textures,
                                                   const Footprints& f,
                                                   Floats& means) const {
  const Floats lod = least(most(f.lod, all(0.0F)), to_floats(textures.last_level));
  const Ints fine = to_ints(lod);
  const Ints coarse = fine < textures.last_level ? fine + 1 : fine;
  const Floats share = lod - to_floats(fine);
  Ints fine_start;
  Ints coarse_start;
  bool any_between = false;
  int most_taps = 1;
  for (std::size_t i = 0; i < kLanes; ++i) {
    fine_start[i] = starts_[static_cast<std::size_t>(textures.first[i] + fine[i])];
    coarse_start[i] = starts_[static_cast<std::size_t>(textures.first[i] + coarse[i])];
    any_between = any_between || share[i] > 0.0F;
    most_taps = std::max(most_taps, int{f.taps[i]});
  }
  Floats sum = {};
  for (int i = 0; i < most_taps; ++i) {
    const Floats offset = static_cast<float>(i) - 0.5F * to_floats(f.taps - 1);
    const Floats u = f.u + offset * f.du;
    const Floats v = f.v + offset * f.dv;
    Floats value = bilinear(texels_.data(), fine_start, textures.size >> fine, u, v);
    if (any_between) {
      const Floats next = bilinear(texels_.data(), coarse_start, textures.size >> coarse, u, v);
      value += share * (next - value);
    }
    sum += f.taps > i ? value : Floats{};
  }
  means = sum / to_floats(f.taps);
}

}  // namespace imslam::simulation
