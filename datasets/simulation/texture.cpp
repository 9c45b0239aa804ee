#include "datasets/simulation/texture.hpp"

#include <algorithm>
#include <utility>

#include "slam/base/error.hpp"

namespace imslam::simulation {
namespace {

constexpr int kWeightBits = 10;
constexpr int kOne = 1 << kWeightBits;
constexpr int kHalfTexel = kOne / 2;

/// floor() without the library call that baseline x86-64 needs for it.
int floor_to_int(float x) {
  const int truncated = static_cast<int>(x);
  return truncated - (x < static_cast<float>(truncated) ? 1 : 0);
}

}  // namespace

Texture::Texture(int size, std::vector<std::uint8_t> pixels)
    : size_(size), pixels_(std::move(pixels)), offsets_{0} {
  expects(size > 0 && (size & (size - 1)) == 0, "Texture: size must be a power of two");
  expects(pixels_.size() == static_cast<std::size_t>(size) * static_cast<std::size_t>(size),
          "Texture: size * size pixels expected");
  for (std::size_t fine = static_cast<std::size_t>(size); fine > 1; fine /= 2) {
    const std::size_t from = offsets_.back();
    const std::size_t coarse = fine / 2;
    offsets_.push_back(from + fine * fine);
    for (std::size_t y = 0; y < coarse; ++y) {
      for (std::size_t x = 0; x < coarse; ++x) {
        const std::size_t corner = from + 2 * y * fine + 2 * x;
        const int sum = pixels_[corner] + pixels_[corner + 1] + pixels_[corner + fine] +
                        pixels_[corner + fine + 1];
        pixels_.push_back(static_cast<std::uint8_t>((sum + 2) / 4));
      }
    }
  }
}

float Texture::bilinear(std::size_t level, float u, float v) const {
  // Fixed point: integers avoid four conversions, and 10 bits of weight are 1/1024 texel.
  const int size = size_ >> level;
  const float scale = static_cast<float>(size << kWeightBits);
  const int x = floor_to_int(u * scale) - kHalfTexel;  // texel centres lie at half integers
  const int y = floor_to_int(v * scale) - kHalfTexel;
  const int fx = x & (kOne - 1);
  const int fy = y & (kOne - 1);
  const int mask = size - 1;
  const auto column0 = static_cast<std::size_t>((x >> kWeightBits) & mask);
  const auto column1 = static_cast<std::size_t>(((x >> kWeightBits) + 1) & mask);
  const auto row0 = static_cast<std::size_t>((y >> kWeightBits) & mask);
  const auto row1 = static_cast<std::size_t>(((y >> kWeightBits) + 1) & mask);
  const std::uint8_t* texels = pixels_.data() + offsets_[level];
  const auto width = static_cast<std::size_t>(size);
  const std::uint8_t* upper = texels + row0 * width;
  const std::uint8_t* lower = texels + row1 * width;
  const int top = upper[column0] * (kOne - fx) + upper[column1] * fx;
  const int bottom = lower[column0] * (kOne - fx) + lower[column1] * fx;
  constexpr float kUnit = 1.0F / (255.0F * kOne * kOne);
  return static_cast<float>(top * (kOne - fy) + bottom * fy) * kUnit;
}

float Texture::sample(float u, float v, float lod) const {
  const float clamped = std::clamp(lod, 0.0F, static_cast<float>(offsets_.size() - 1));
  const auto fine = static_cast<std::size_t>(clamped);
  const float share = clamped - static_cast<float>(fine);
  const float value = bilinear(fine, u, v);
  if (share < 1e-3F || fine + 1 == offsets_.size()) return value;
  return value + share * (bilinear(fine + 1, u, v) - value);
}

}  // namespace imslam::simulation
