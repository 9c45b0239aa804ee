#include "vo_net/match_polish.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "tests/vo_net/synthetic_images.hpp"

namespace imslam::vo {
namespace {

constexpr int kSize = 128;
constexpr double kNoise = 12.0;  // [grey levels]
const Eigen::Vector2d kCenter(63.4, 65.1);
const Eigen::Vector2d kShift(4.3, -2.6);

/// A coarse texture moved by `shift` px and smeared over `smear` px, with noise.
ImagePyramid picture(const Eigen::Vector2d& shift, const Eigen::Vector2d& smear, double noise) {
  Random texture_random(8);
  const testing::SplineTexture texture(texture_random, 14.0);
  Random random(static_cast<std::uint64_t>(100.0 * shift.norm()) + 1);
  GrayImage image{kSize, kSize, {}};
  for (int y = 0; y < kSize; ++y) {
    for (int x = 0; x < kSize; ++x) {
      double sum = 0.0;
      for (int i = -4; i <= 4; ++i) {
        const Eigen::Vector2d p = Eigen::Vector2d(x, y) - shift + smear * (i / 8.0);
        sum += texture.at(p.x() + 500.0, p.y() + 500.0);
      }
      const double value = 0.6 * sum / 9.0 + 50.0 + noise * random.normal();
      image.pixels.push_back(static_cast<std::uint8_t>(std::clamp(std::lround(value), 0L, 255L)));
    }
  }
  ImagePyramid pyramid;
  pyramid.build(image, 3, 0.8);
  return pyramid;
}

/// As a network answers: `error` px off, with standard deviation `sigma` px.
NetworkAnswer answer(const Eigen::Vector2d& error, double sigma) {
  NetworkAnswer said;
  said.displacement = kShift + error;
  said.covariance = sigma * sigma * Eigen::Matrix2d::Identity();
  said.confidence = 0.9;
  return said;
}

MatchPolish make_polish(int coarse = LearnedMatcherOptions().coarse_polish) {
  LearnedMatcherOptions options;
  options.polish_window = 15;
  options.coarse_polish = coarse;
  return MatchPolish(options);
}

TEST(MatchPolish, CoarseFindsWhatFullSizeLeavesAlone) {
  const ImagePyramid from = picture(Eigen::Vector2d::Zero(), {0.0, 0.0}, kNoise);
  const ImagePyramid to = picture(kShift, {6.0, 4.0}, kNoise);
  const NetworkAnswer said = answer({1.6, 1.2}, 4.0);  // too uncertain for full size
  EXPECT_FALSE(make_polish().polish(from, kCenter, to, said));
  const auto found = make_polish().polish_coarse(from, kCenter, to, said);
  ASSERT_TRUE(found);
  const Eigen::Vector2d error = found->position - kCenter - kShift;
  EXPECT_LT(error.norm(), 1.0);  // half of the answer's
  // Its covariance is about the error, in pixels of the whole image.
  EXPECT_LT(error.dot(found->covariance.inverse() * error), 9.0);
  EXPECT_GT(found->covariance.trace(), 1e-3);
}

TEST(MatchPolish, LimitsGrowWithTheSizeOfAPixel) {
  const ImagePyramid from = picture(Eigen::Vector2d::Zero(), {0.0, 0.0}, 0.0);
  const ImagePyramid to = picture(kShift, {0.0, 0.0}, 0.0);
  // 3 px at full size, 6 at half, 12 at quarter size.
  EXPECT_FALSE(make_polish(1).polish_coarse(from, kCenter, to, answer({0.5, 0.5}, 7.0)));
  EXPECT_TRUE(make_polish(2).polish_coarse(from, kCenter, to, answer({0.5, 0.5}, 7.0)));
  EXPECT_FALSE(make_polish(2).polish_coarse(from, kCenter, to, answer({0.5, 0.5}, 13.0)));
  EXPECT_FALSE(make_polish(0).polish_coarse(from, kCenter, to, answer({0.5, 0.5}, 1.0)));
}

TEST(MatchPolish, CoarseLeavesOtherThingsAlone) {
  const ImagePyramid from = picture(Eigen::Vector2d::Zero(), {0.0, 0.0}, 2.0);
  const ImagePyramid elsewhere = picture({211.0, 87.0}, {0.0, 0.0}, 2.0);
  EXPECT_FALSE(make_polish().polish_coarse(from, kCenter, elsewhere, answer({0.0, 0.0}, 2.0)));
}

}  // namespace
}  // namespace imslam::vo
