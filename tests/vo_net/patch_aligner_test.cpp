#include "vo_net/patch_aligner.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "tests/vo_net/synthetic_images.hpp"

namespace imslam::vo {
namespace {

constexpr int kSize = 96;

/// The texture moved by `shift` px, with contrast, brightness and noise [grey].
GrayImage shifted(const Eigen::Vector2d& shift,
                  double gain,
                  double offset,
                  double noise,
                  std::uint64_t noise_seed = 1) {
  Random texture_random(3);
  const testing::SplineTexture texture(texture_random, 6.0);
  Random random(noise_seed);
  GrayImage image{kSize, kSize, {}};
  for (int y = 0; y < kSize; ++y) {
    for (int x = 0; x < kSize; ++x) {
      const double value = gain * texture.at(x - shift.x() + 500.0, y - shift.y() + 500.0) +
                           offset + noise * random.normal();
      image.pixels.push_back(static_cast<std::uint8_t>(std::clamp(std::lround(value), 0L, 255L)));
    }
  }
  return image;
}

ImagePyramid pyramid(const GrayImage& image, double smoothing = 0.0) {
  ImagePyramid result;
  result.build(image, 3, smoothing);
  return result;
}

const Eigen::Vector2d kCenter(48.3, 45.8);

TEST(PatchAligner, FindsSubPixelShifts) {
  const ImagePyramid from = pyramid(shifted({0.0, 0.0}, 0.6, 50.0, 0.0));
  for (const Eigen::Vector2d& shift :
       {Eigen::Vector2d(0.0, 0.0), Eigen::Vector2d(0.37, -0.61), Eigen::Vector2d(5.25, -3.5)}) {
    const ImagePyramid to = pyramid(shifted(shift, 0.6, 50.0, 0.0));
    const Alignment found = align_patch(from, kCenter, to, kCenter, 2, {}, false);
    ASSERT_TRUE(found.found);
    EXPECT_LT((found.position - kCenter - shift).norm(), 0.03) << shift.transpose();
    EXPECT_GT(found.correlation, 0.99);
  }
}

TEST(PatchAligner, IsBlindToGainAndOffset) {
  const ImagePyramid from = pyramid(shifted({0.0, 0.0}, 0.6, 50.0, 0.0));
  const Eigen::Vector2d shift(1.4, 0.8);
  for (double gain : {0.15, 0.4, 0.9}) {
    const ImagePyramid to = pyramid(shifted(shift, gain, 20.0, 0.0));
    const Alignment found = align_patch(from, kCenter, to, kCenter, 2, {}, false);
    ASSERT_TRUE(found.found);
    EXPECT_LT((found.position - kCenter - shift).norm(), 0.06) << gain;
    EXPECT_NEAR(found.gain, gain / 0.6, 0.03);
  }
}

TEST(PatchAligner, AlongTheRowOnlyUChanges) {
  const ImagePyramid from = pyramid(shifted({0.0, 0.0}, 0.6, 50.0, 0.0));
  const ImagePyramid to = pyramid(shifted({2.3, 0.0}, 0.6, 50.0, 0.0));
  const Alignment found = align_patch(from, kCenter, to, kCenter, 1, {}, true);
  ASSERT_TRUE(found.found);
  EXPECT_EQ(found.position.y(), kCenter.y());
  EXPECT_NEAR(found.position.x() - kCenter.x(), 2.3, 0.03);
}

TEST(PatchAligner, CovarianceIsThatOfTheError) {
  const double noise = 6.0;
  const int runs = 150;
  double nees = 0.0;
  int counted = 0;
  for (int run = 0; run < runs; ++run) {
    const auto seed = static_cast<std::uint64_t>(10 + 2 * run);
    const ImagePyramid from = pyramid(shifted({0.0, 0.0}, 0.6, 50.0, noise, seed));
    const ImagePyramid to = pyramid(shifted({0.4, 0.3}, 0.6, 50.0, noise, seed + 1));
    const Alignment found = align_patch(from, kCenter, to, kCenter, 1, {}, false);
    ASSERT_TRUE(found.found);
    const Eigen::Vector2d e = found.position - kCenter - Eigen::Vector2d(0.4, 0.3);
    nees += e.dot(found.covariance.inverse() * e);
    ++counted;
  }
  // Interpolation makes the noise of neighbours alike, hence not exactly 2.
  EXPECT_GT(nees / counted, 1.0);
  EXPECT_LT(nees / counted, 4.0);
}

TEST(PatchAligner, RefusesPatchesWithoutTexture) {
  const GrayImage flat{kSize, kSize, std::vector<std::uint8_t>(kSize * kSize, 90)};
  const ImagePyramid image = pyramid(flat);
  EXPECT_FALSE(align_patch(image, kCenter, image, kCenter, 2, {}, false).found);
  const ImagePyramid textured = pyramid(shifted({0.0, 0.0}, 0.6, 50.0, 0.0));
  EXPECT_FALSE(align_patch(textured, kCenter, image, kCenter, 2, {}, false).found);
}

TEST(PatchAligner, RefusesPatchesThatLeaveTheImage) {
  const ImagePyramid image = pyramid(shifted({0.0, 0.0}, 0.6, 50.0, 0.0));
  for (const Eigen::Vector2d& start :
       {Eigen::Vector2d(-500.0, 3.0), Eigen::Vector2d(3.0, 1e9), Eigen::Vector2d(2.0, 2.0)}) {
    EXPECT_FALSE(align_patch(image, kCenter, image, start, 0, {}, false).found)
        << start.transpose();
  }
  const double nan = std::nan("");
  EXPECT_FALSE(align_patch(image, kCenter, image, {nan, nan}, 0, {}, false).found);
}

TEST(ImagePyramid, LevelsAgreeOnPositions) {
  const ImagePyramid image = pyramid(shifted({0.0, 0.0}, 0.6, 50.0, 0.0));
  ASSERT_EQ(image.levels().size(), 3U);
  for (int y = 10; y < 80; y += 10) {
    for (int x = 10; x < 80; x += 10) {
      EXPECT_NEAR(static_cast<double>(*image[1].at(x / 2, y / 2)),
                  static_cast<double>(*image[0].at(x, y)), 30.0);
    }
  }
}

TEST(ImagePyramid, CopyDoesNotShareItsPixels) {
  ImagePyramid image = pyramid(shifted({0.0, 0.0}, 0.6, 50.0, 0.0));
  const float before = *image[0].at(5, 5);
  const ImagePyramid copy = image;
  image.build({kSize, kSize, std::vector<std::uint8_t>(kSize * kSize, 1)}, 3, 0.0);
  EXPECT_EQ(*copy[0].at(5, 5), before);
  EXPECT_EQ(*image[0].at(5, 5), 1.0F);
}

}  // namespace
}  // namespace imslam::vo
