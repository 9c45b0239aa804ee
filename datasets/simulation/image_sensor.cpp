#include "datasets/simulation/image_sensor.hpp"

#include <algorithm>
#include <array>
#include <cmath>

#include "slam/base/parallel.hpp"

namespace imslam::simulation {
namespace {

constexpr std::size_t kQuantiles = 1U << 12U;

/// Inverse of the standard normal distribution by bisection on erfc.
double normal_quantile(double probability) {
  double low = -9.0;
  double high = 9.0;
  for (int i = 0; i < 60; ++i) {
    const double middle = 0.5 * (low + high);
    (0.5 * std::erfc(-middle * M_SQRT1_2) < probability ? low : high) = middle;
  }
  return 0.5 * (low + high);
}

/// Equally likely values of a standard normal variable: a draw is a look-up with 12 random bits.
const std::array<float, kQuantiles>& normal_table() {
  static const std::array<float, kQuantiles> table = [] {
    std::array<float, kQuantiles> values{};
    for (std::size_t i = 0; i < kQuantiles; ++i) {
      values[i] = static_cast<float>(normal_quantile((static_cast<double>(i) + 0.5) / kQuantiles));
    }
    return values;
  }();
  return table;
}

/// SplitMix64: random bits as a function of a counter, so rows can be done in any order.
std::uint64_t hashed(std::uint64_t x) {
  x += 0x9E3779B97F4A7C15ULL;
  x = (x ^ (x >> 30U)) * 0xBF58476D1CE4E5B9ULL;
  x = (x ^ (x >> 27U)) * 0x94D049BB133111EBULL;
  return x ^ (x >> 31U);
}

}  // namespace

ImageSensor::ImageSensor(const ImageOptions& options, const Lens& lens)
    : width_(lens.width()),
      height_(lens.height()),
      read_variance_(std::pow(options.noise_scale * options.read_noise, 2)),
      shot_(options.noise_scale * options.noise_scale * options.shot_noise) {
  const double cx = lens.intrinsics()[2];
  const double cy = lens.intrinsics()[3];
  const double corner = std::hypot(std::max(cx, width_ - cx), std::max(cy, height_ - cy));
  for (int row = 0; row < height_; ++row) {
    for (int column = 0; column < width_; ++column) {
      const double r = std::hypot(column - cx, row - cy) / corner;
      vignette_.push_back(static_cast<float>(255.0 * (1.0 - options.vignetting * r * r)));
    }
  }
  for (int grey = 0; grey < 256; ++grey) {
    sigmas_.push_back(static_cast<float>(std::sqrt(read_variance_ + shot_ * grey)));
  }
}

GrayImage ImageSensor::expose(const std::vector<float>& radiance,
                              double gain,
                              std::uint64_t noise_seed) const {
  GrayImage image{width_, height_, std::vector<std::uint8_t>(radiance.size())};
  const auto& normal = normal_table();
  const bool noisy = read_variance_ + shot_ > 0.0;
  const auto factor = static_cast<float>(gain);
  const auto width = static_cast<std::size_t>(width_);
  parallel_for(static_cast<std::size_t>(height_), [&](std::size_t row) {
    std::uint64_t bits = 0;
    for (std::size_t i = row * width; i < (row + 1) * width; ++i) {
      const std::size_t column = i - row * width;
      float grey = std::min(radiance[i] * factor * vignette_[i], 255.0F);
      if (noisy) {
        if (column % 5 == 0) bits = hashed(noise_seed + i);  // 60 bits serve five pixels
        grey += sigmas_[static_cast<std::size_t>(grey)] * normal[bits & (kQuantiles - 1)];
        bits >>= 12U;
      }
      image.pixels[i] = static_cast<std::uint8_t>(std::clamp(grey + 0.5F, 0.0F, 255.0F));
    }
  });
  return image;
}

}  // namespace imslam::simulation
