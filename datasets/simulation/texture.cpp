#include "datasets/simulation/texture.hpp"

#include <algorithm>
#include <utility>

#include "slam/base/error.hpp"

namespace imslam::simulation {
namespace {

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
  const int size = size_ >> level;
  const float x = u * static_cast<float>(size) - 0.5F;  // texel centres lie at half integers
  const float y = v * static_cast<float>(size) - 0.5F;
  const int x0 = floor_to_int(x);
  const int y0 = floor_to_int(y);
  const float fx = x - static_cast<float>(x0);
  const float fy = y - static_cast<float>(y0);
  const int mask = size - 1;
  const auto column0 = static_cast<std::size_t>(x0 & mask);
  const auto column1 = static_cast<std::size_t>((x0 + 1) & mask);
  const auto width = static_cast<std::size_t>(size);
  const std::uint8_t* row0 = &pixels_[offsets_[level] + static_cast<std::size_t>(y0 & mask) * width];
  const std::uint8_t* row1 =
      &pixels_[offsets_[level] + static_cast<std::size_t>((y0 + 1) & mask) * width];
  const float a00 = row0[column0];
  const float a01 = row0[column1];
  const float a10 = row1[column0];
  const float a11 = row1[column1];
  const float top = a00 + fx * (a01 - a00);
  const float bottom = a10 + fx * (a11 - a10);
  return (top + fy * (bottom - top)) * (1.0F / 255.0F);
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
