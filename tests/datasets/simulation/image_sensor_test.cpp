#include "datasets/simulation/image_sensor.hpp"

#include <gtest/gtest.h>

#include <cmath>

namespace imslam::simulation {
namespace {

const Lens kLens(Distortion::kRadTan, 200, 100, {100, 100, 100, 50}, {});

std::vector<float> even(float radiance) { return std::vector<float>(200 * 100, radiance); }

struct Moments {
  double mean = 0.0;
  double variance = 0.0;
};

Moments moments(const GrayImage& image) {
  double sum = 0.0;
  double squares = 0.0;
  for (const std::uint8_t grey : image.pixels) {
    sum += grey;
    squares += grey * grey;
  }
  const auto n = static_cast<double>(image.pixels.size());
  return {sum / n, squares / n - sum * sum / (n * n)};
}

TEST(ImageSensor, NoiseHasReadAndShotVariance) {
  ImageOptions options;
  options.vignetting = 0.0;
  options.read_noise = 2.0;
  options.shot_noise = 0.05;
  const ImageSensor sensor(options, kLens);
  for (const float radiance : {0.2F, 0.6F}) {
    const Moments m = moments(sensor.expose(even(radiance), 1.0, 99));
    const double grey = 255.0 * radiance;
    EXPECT_NEAR(m.mean, grey, 0.1);
    EXPECT_NEAR(m.variance, 4.0 + 0.05 * grey + 1.0 / 12.0, 0.4);
  }
}

TEST(ImageSensor, IsExactWithoutNoiseAndSaturates) {
  ImageOptions options;
  options.vignetting = 0.0;
  options.noise_scale = 0.0;
  const ImageSensor sensor(options, kLens);
  EXPECT_EQ(sensor.expose(even(0.5F), 1.0, 1).at(10, 10), 128);
  EXPECT_EQ(sensor.expose(even(0.5F), 3.0, 1).at(10, 10), 255);
  EXPECT_EQ(sensor.expose(even(0.0F), 3.0, 1).at(10, 10), 0);
}

TEST(ImageSensor, VignettingDarkensTheCorners) {
  ImageOptions options;
  options.vignetting = 0.4;
  options.noise_scale = 0.0;
  const GrayImage image = ImageSensor(options, kLens).expose(even(0.8F), 1.0, 1);
  EXPECT_NEAR(image.at(50, 100), 204, 1);
  EXPECT_NEAR(image.at(0, 0), 204 * 0.6, 1);
}

TEST(ImageSensor, NoiseIsGivenByItsSeed) {
  const ImageSensor sensor(ImageOptions(), kLens);
  EXPECT_EQ(sensor.expose(even(0.5F), 1.0, 5).pixels, sensor.expose(even(0.5F), 1.0, 5).pixels);
  EXPECT_NE(sensor.expose(even(0.5F), 1.0, 5).pixels, sensor.expose(even(0.5F), 1.0, 6).pixels);
}

}  // namespace
}  // namespace imslam::simulation
