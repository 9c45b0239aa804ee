#include "slam/training/degradation.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <map>
#include <numeric>
#include <string>

#include "slam/base/random.hpp"

namespace imslam::training {
namespace {

constexpr int kWidth = 192;
constexpr int kHeight = 96;
constexpr std::size_t kPixels = std::size_t{kWidth} * kHeight;

std::vector<float> even(float grey) { return std::vector<float>(kPixels, grey); }

/// Everything from 0 to 255, sharp and smooth.
std::vector<float> busy() {
  Random random(3);
  std::vector<float> grey(kPixels);
  for (std::size_t i = 0; i < kPixels; ++i) {
    const auto column = static_cast<float>(i % kWidth);
    grey[i] =
        column < 96 ? 255.0F * static_cast<float>(random.uniform()) : 255.0F * column / 191.0F;
  }
  return grey;
}

std::vector<float> degraded(const ViewDegradation& d, std::vector<float> grey) {
  degrade(d, kWidth, kHeight, 7, grey);
  return grey;
}

double mean(const std::vector<float>& grey) {
  return std::accumulate(grey.begin(), grey.end(), 0.0) / static_cast<double>(grey.size());
}

double variance(const std::vector<float>& grey) {
  const double centre = mean(grey);
  double sum = 0.0;
  for (const float value : grey) sum += (value - centre) * (value - centre);
  return sum / static_cast<double>(grey.size());
}

/// Each effect alone, as strong as options allow it.
std::map<std::string, ViewDegradation> strong_effects() {
  std::map<std::string, ViewDegradation> effects;
  effects["haze"].haze = 1.0F;
  effects["motion"].motion = {40.0F, -30.0F, 20.0F, -20.0F, 20.0F, 10.0F};
  effects["turning"].motion.u_y = 10.0F;
  effects["defocus"].defocus = {10.0F, 1.0F, -1.0F};
  effects["bright"].gain = 100.0F;
  effects["dim"].gain = 0.01F;
  effects["dark"].darkness = 0.001F;
  effects["vignetting"].vignetting = 1.0F;
  effects["vignetting"].vignette_x = 0.3F;
  effects["read noise"].read_noise = 255.0F;
  effects["shot noise"].shot_noise = 100.0F;
  effects["amplified noise"].read_noise = 2.0F;
  effects["amplified noise"].darkness = 0.001F;
  effects["amplified noise"].amplification = 1000.0F;
  effects["low gamma"].gamma = 0.2F;
  effects["high gamma"].gamma = 5.0F;
  effects["hot pixels"].hot_pixels = 1000;
  effects["quantisation"].quantise = true;
  return effects;
}

TEST(Degradation, EveryEffectChangesTheImageAndStaysWithinItsRange) {
  const std::vector<float> before = busy();
  for (const auto& [name, effect] : strong_effects()) {
    const std::vector<float> after = degraded(effect, before);
    EXPECT_NE(after, before) << name;
    for (const float grey : after) {
      ASSERT_TRUE(std::isfinite(grey)) << name;
      ASSERT_GE(grey, 0.0F) << name;
      ASSERT_LE(grey, 255.0F) << name;
    }
    EXPECT_EQ(degraded(effect, before), after) << name;
  }
}

TEST(Degradation, DefaultsChangeNothing) { EXPECT_EQ(degraded({}, busy()), busy()); }

TEST(Degradation, BlurKeepsEvenImagesAndTakesAwayContrast) {
  for (const char* name : {"motion", "turning", "defocus"}) {
    const ViewDegradation effect = strong_effects()[name];
    for (const float grey : degraded(effect, even(77.0F))) ASSERT_NEAR(grey, 77.0F, 1e-3F) << name;
    EXPECT_LT(variance(degraded(effect, busy())), variance(busy())) << name;
  }
}

/// The share of the light of a bright dot that each pixel got.
std::vector<float> spread_of_a_dot(const ViewDegradation& effect, int column, int row) {
  std::vector<float> grey = even(0.0F);
  grey[static_cast<std::size_t>(row * kWidth + column)] = 250.0F;
  grey = degraded(effect, grey);
  for (float& value : grey) value /= 250.0F;
  return grey;
}

TEST(Degradation, DefocusSpreadsADotAsAGaussian) {
  ViewDegradation effect;
  effect.defocus.sigma = 2.0F;
  const std::vector<float> spread = spread_of_a_dot(effect, 100, 50);
  double variance_x = 0.0;
  double variance_y = 0.0;
  for (std::size_t i = 0; i < kPixels; ++i) {
    variance_x += spread[i] * std::pow(static_cast<double>(i % kWidth) - 100.0, 2);
    variance_y += spread[i] * std::pow(static_cast<double>(i / kWidth) - 50.0, 2);
  }
  EXPECT_NEAR(mean(spread) * kPixels, 1.0, 1e-4);
  EXPECT_NEAR(variance_x, 4.0, 0.15);  // cut at three sigmas
  EXPECT_NEAR(variance_y, 4.0, 0.15);
}

TEST(Degradation, MotionSpreadsADotAlongACentredLine) {
  ViewDegradation effect;
  effect.motion.u = 12.0F;
  const std::vector<float> spread = spread_of_a_dot(effect, 100, 50);
  double place = 0.0;
  for (int column = 0; column < kWidth; ++column) {
    const float share = spread[static_cast<std::size_t>(50 * kWidth + column)];
    place += column * double{share};
    if (std::abs(column - 100) > 7) {
      EXPECT_EQ(share, 0.0F) << column;
    } else if (std::abs(column - 100) < 5) {
      EXPECT_NEAR(share, 1.0F / 12.0F, 0.01F) << column;
    }
  }
  EXPECT_NEAR(place, 100.0, 1e-3);  // centred: the truth stays where it is
  EXPECT_NEAR(mean(spread) * kPixels, 1.0, 1e-4);
}

TEST(Degradation, MotionBlurVariesOverTheImage) {
  ViewDegradation zoom;  // nothing in the middle, outwards at the borders
  zoom.motion.u_x = 16.0F;
  EXPECT_GT(spread_of_a_dot(zoom, 96, 50)[50 * kWidth + 96], 0.9F);
  EXPECT_LT(spread_of_a_dot(zoom, 180, 50)[50 * kWidth + 180], 0.15F);
}

TEST(Degradation, DefocusVariesOverTheImage) {
  ViewDegradation tilted;
  tilted.defocus = {3.0F, 1.0F, 0.0F};  // sharp at the left border
  EXPECT_GT(spread_of_a_dot(tilted, 1, 50)[50 * kWidth + 1], 0.9F);
  EXPECT_LT(spread_of_a_dot(tilted, 150, 50)[50 * kWidth + 150], 0.1F);
}

TEST(Degradation, NoiseHasReadAndShotVariance) {
  ViewDegradation noisy;
  noisy.read_noise = 3.0F;
  noisy.shot_noise = 0.2F;
  for (const float grey : {60.0F, 180.0F}) {
    const std::vector<float> after = degraded(noisy, even(grey));
    EXPECT_NEAR(mean(after), grey, 0.2);
    EXPECT_NEAR(variance(after), 9.0 + 0.2 * grey, 0.05 * (9.0 + 0.2 * grey));
  }
}

TEST(Degradation, NoiseOfNeighboursIsIndependent) {
  ViewDegradation noisy;
  noisy.read_noise = 10.0F;
  const std::vector<float> after = degraded(noisy, even(128.0F));
  double product = 0.0;
  for (std::size_t i = 1; i < kPixels; ++i) product += (after[i] - 128.0) * (after[i - 1] - 128.0);
  EXPECT_LT(std::abs(product / kPixels), 3.0);  // against a variance of 100
}

TEST(Degradation, ExposureScalesAndSaturates) {
  ViewDegradation exposed;
  exposed.gain = 3.0F;
  EXPECT_EQ(degraded(exposed, even(50.0F)), even(150.0F));
  EXPECT_EQ(degraded(exposed, even(120.0F)), even(255.0F));
  exposed.darkness = 0.1F;
  EXPECT_NEAR(degraded(exposed, even(50.0F))[0], 15.0F, 1e-4F);
  exposed.amplification = 10.0F;
  EXPECT_NEAR(degraded(exposed, even(50.0F))[0], 150.0F, 1e-3F);
}

TEST(Degradation, VignettingDarkensTheFarCornerByItsShare) {
  ViewDegradation effect;
  effect.vignetting = 0.6F;
  const std::vector<float> after = degraded(effect, even(100.0F));
  EXPECT_NEAR(after[0], 40.0F, 1e-3F);
  EXPECT_NEAR(after[48 * kWidth + 96], 100.0F, 0.1F);
}

TEST(Degradation, HazeAndGammaFollowTheirFormulas) {
  ViewDegradation hazy;
  hazy.haze = 0.75F;
  hazy.airlight = 200.0F;
  EXPECT_NEAR(degraded(hazy, even(100.0F))[5], 175.0F, 1e-3F);
  ViewDegradation bent;
  for (const float gamma : {0.5F, 2.2F}) {
    bent.gamma = gamma;
    for (const float grey : {0.0F, 20.3F, 128.0F, 255.0F})
      EXPECT_NEAR(degraded(bent, even(grey))[5], 255.0F * std::pow(grey / 255.0F, gamma), 0.02F);
  }
}

TEST(Degradation, QuantisationRoundsToWholeGreyLevels) {
  ViewDegradation effect;
  effect.quantise = true;
  const std::vector<float> before = busy();
  const std::vector<float> after = degraded(effect, before);
  for (std::size_t i = 0; i < kPixels; ++i) {
    ASSERT_EQ(after[i], std::round(after[i]));
    ASSERT_LE(std::abs(after[i] - before[i]), 0.5F);
  }
}

TEST(Degradation, HotPixelsStayWhereTheyAre) {
  ViewDegradation effect;
  effect.hot_pixels = 20;
  effect.hot_seed = 5;
  const std::vector<float> dark = degraded(effect, even(10.0F));
  const std::vector<float> light = degraded(effect, even(100.0F));
  int hot = 0;
  for (std::size_t i = 0; i < kPixels; ++i) {
    EXPECT_EQ(dark[i] > 10.0F, light[i] > 100.0F);
    hot += dark[i] > 10.0F ? 1 : 0;
  }
  EXPECT_GT(hot, 15);
  EXPECT_LE(hot, 20);
}

}  // namespace
}  // namespace imslam::training
