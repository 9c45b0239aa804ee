#include "slam/training/degradation.hpp"

#include <algorithm>
#include <array>
#include <cmath>

#include "slam/base/error.hpp"
#include "slam/base/random.hpp"
#include "slam/training/blur.hpp"

namespace imslam::training {
namespace {

constexpr float kWhite = 255.0F;

/// SplitMix64: random bits as a function of a counter.
inline std::uint64_t hashed(std::uint64_t x) {
  x += 0x9E3779B97F4A7C15ULL;
  x = (x ^ (x >> 30U)) * 0xBF58476D1CE4E5B9ULL;
  x = (x ^ (x >> 27U)) * 0x94D049BB133111EBULL;
  return x ^ (x >> 31U);
}

/// Variance 1, nearly normal (excess kurtosis -0.3): the sum of four uniform numbers.
inline float nearly_normal(std::uint64_t bits) {
  const auto sum = static_cast<std::int32_t>((bits & 0xFFFF) + (bits >> 16U & 0xFFFF) +
                                             (bits >> 32U & 0xFFFF) + (bits >> 48U));
  constexpr float kCentre = 2.0F * 65535.0F;
  constexpr float kScale = 1.7320508F / 65536.0F;  // of four uniforms the variance is 1/3
  return (static_cast<float>(sum) - kCentre) * kScale;
}

void add_haze(const ViewDegradation& d, std::vector<float>& grey) {
  for (float& value : grey) value += d.haze * (d.airlight - value);
}

bool changes_exposure(const ViewDegradation& d) {
  return d.gain != 1.0F || d.darkness != 1.0F || d.vignetting != 0.0F;
}

void expose(const ViewDegradation& d, int width, int height, std::vector<float>& grey) {
  const float farthest_x = 1.0F + std::abs(d.vignette_x);
  const float farthest_y = 1.0F + std::abs(d.vignette_y);
  const float loss = d.vignetting / (farthest_x * farthest_x + farthest_y * farthest_y);
  const float factor = d.gain * d.darkness;
  for (int row = 0; row < height; ++row) {
    float* to = grey.data() + row * width;
    const float y =
        2.0F * static_cast<float>(row) / static_cast<float>(height - 1) - 1.0F - d.vignette_y;
    for (int column = 0; column < width; ++column) {
      const float x =
          2.0F * static_cast<float>(column) / static_cast<float>(width - 1) - 1.0F - d.vignette_x;
      to[column] = std::min(kWhite, factor * (1.0F - loss * (x * x + y * y)) * to[column]);
    }
  }
}

void add_noise(const ViewDegradation& d, std::uint64_t seed, std::vector<float>& grey) {
  const float read_variance = d.read_noise * d.read_noise;
  const std::uint64_t start = hashed(seed);
  for (std::size_t i = 0; i < grey.size(); ++i) {
    const float sigma = std::sqrt(read_variance + d.shot_noise * grey[i]);
    grey[i] += sigma * nearly_normal(hashed(start + i));
  }
}

void add_hot_pixels(const ViewDegradation& d, std::vector<float>& grey) {
  Random random(d.hot_seed);
  for (int i = 0; i < d.hot_pixels; ++i) {
    const auto at =
        static_cast<std::size_t>(random.integer(0, static_cast<std::int64_t>(grey.size()) - 1));
    grey[at] += static_cast<float>(random.uniform(40.0, 255.0));
  }
}

/// The response curve by a table: 8 entries per grey level, linear between them.
void respond(float gamma, std::vector<float>& grey) {
  constexpr std::size_t kPerGrey = 8;
  std::array<float, 255 * kPerGrey + 2> table{};
  for (std::size_t i = 0; i < table.size(); ++i) {
    const float light = static_cast<float>(i) / (kWhite * kPerGrey);
    table[i] = kWhite * std::min(1.0F, std::pow(light, gamma));
  }
  for (float& value : grey) {
    const float at = value * kPerGrey;
    const auto below = static_cast<std::size_t>(at);
    value = table[below] + (at - static_cast<float>(below)) * (table[below + 1] - table[below]);
  }
}

void clip(float factor, std::vector<float>& grey) {
  for (float& value : grey) value = std::min(std::max(factor * value, 0.0F), kWhite);
}

bool moves(const MotionBlur& m) {
  return m.u != 0.0F || m.v != 0.0F || m.u_x != 0.0F || m.u_y != 0.0F || m.v_x != 0.0F ||
         m.v_y != 0.0F;
}

}  // namespace

void degrade(const ViewDegradation& d,
             int width,
             int height,
             std::uint64_t noise_seed,
             std::vector<float>& grey) {
  expects(width > 1 && height > 1 && width % 16 == 0, "degrade: width must be a multiple of 16");
  expects(grey.size() == static_cast<std::size_t>(width) * static_cast<std::size_t>(height),
          "degrade: width * height pixels expected");
  if (d.haze > 0.0F) add_haze(d, grey);
  if (moves(d.motion)) blur_motion(d.motion, width, height, grey);
  if (d.defocus.sigma > 0.0F) blur_defocus(d.defocus, width, height, grey);
  if (changes_exposure(d)) expose(d, width, height, grey);
  if (d.read_noise > 0.0F || d.shot_noise > 0.0F) add_noise(d, noise_seed, grey);
  if (d.hot_pixels > 0) add_hot_pixels(d, grey);
  clip(d.amplification, grey);
  if (d.gamma != 1.0F) respond(d.gamma, grey);
  if (d.quantise) {
    for (float& value : grey) value = std::floor(value + 0.5F);
  }
}

}  // namespace imslam::training
