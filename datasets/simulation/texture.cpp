#include "datasets/simulation/texture.hpp"

#include <utility>

#include "slam/base/error.hpp"

namespace imslam::simulation {

Texture::Texture(int size, std::vector<std::uint8_t> pixels)
    : size_(size), pixels_(std::move(pixels)) {
  expects(size > 0 && (size & (size - 1)) == 0, "Texture: size must be a power of two");
  expects(pixels_.size() == static_cast<std::size_t>(size) * static_cast<std::size_t>(size),
          "Texture: size * size pixels expected");
  std::size_t from = 0;
  for (std::size_t fine = static_cast<std::size_t>(size); fine > 1; fine /= 2) {
    const std::size_t coarse = fine / 2;
    for (std::size_t y = 0; y < coarse; ++y) {
      for (std::size_t x = 0; x < coarse; ++x) {
        const std::size_t corner = from + 2 * y * fine + 2 * x;
        const int sum = pixels_[corner] + pixels_[corner + 1] + pixels_[corner + fine] +
                        pixels_[corner + fine + 1];
        pixels_.push_back(static_cast<std::uint8_t>((sum + 2) / 4));
      }
    }
    from += fine * fine;
  }
}

}  // namespace imslam::simulation
