#include "vo_net/local_normalisation.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "slam/base/random.hpp"

namespace imslam::vo {
namespace {

using nn::Index;
using nn::Tensor;

template <typename S>
Tensor<S> normalised(const Tensor<S>& image, const LocalNormalisationOptions& options = {}) {
  nn::Tape<S> tape(nn::Mode::kInference);
  return tape.copy(local_normalisation(tape, tape.constant(image), options));
}

Tensor<double> noise(const nn::Shape& shape, std::uint64_t seed) {
  Random random(seed);
  Tensor<double> image(shape);
  for (Index i = 0; i < image.size(); ++i) image[i] = random.uniform(0.0, 255.0);
  return image;
}

/// The definition, window by window.
double slow_reference(
    const Tensor<double>& image, Index n, Index row, Index column, Index radius, double floor) {
  const Index height = image.shape()[1];
  const Index width = image.shape()[2];
  const auto at = [&](Index i, Index j) { return image[(n * height + i) * width + j]; };
  double count = 0.0;
  double sum = 0.0;
  double squares = 0.0;
  for (Index i = std::max<Index>(0, row - radius); i <= std::min(height - 1, row + radius); ++i) {
    for (Index j = std::max<Index>(0, column - radius); j <= std::min(width - 1, column + radius);
         ++j) {
      count += 1.0;
      sum += at(i, j);
      squares += at(i, j) * at(i, j);
    }
  }
  const double mean = sum / count;
  const double variance = squares / count - mean * mean;
  return (at(row, column) - mean) / std::sqrt(variance + floor * floor);
}

TEST(LocalNormalisation, IsWhatItsDefinitionSaysAtAnySize) {
  const nn::Shape shapes[] = {{1, 53, 70, 1}, {2, 5, 3, 1}, {1, 1, 1, 1}, {1, 290, 20, 1}};
  const LocalNormalisationOptions options;
  for (const nn::Shape& shape : shapes) {
    const Tensor<double> image = noise(shape, 3);
    const Tensor<double> z = normalised(image);
    ASSERT_EQ(z.shape().text(), shape.with_channels(2).text());
    for (Index n = 0, at = 0; n < shape[0]; ++n) {
      for (Index i = 0; i < shape[1]; ++i) {
        for (Index j = 0; j < shape[2]; ++j) {
          for (const int radius : {options.small_radius, options.large_radius}) {
            ASSERT_NEAR(z[at++], slow_reference(image, n, i, j, radius, options.noise_floor), 1e-9)
                << shape.text() << " " << n << " " << i << " " << j << " " << radius;
          }
        }
      }
    }
  }
}

TEST(LocalNormalisation, FloatAgreesWithDouble) {
  const Tensor<double> image = noise({1, 140, 33, 1}, 4);
  const Tensor<double> exact = normalised(nn::cast<double>(nn::cast<float>(image)));
  const Tensor<float> fast = normalised(nn::cast<float>(image));
  for (Index i = 0; i < exact.size(); ++i) {
    ASSERT_NEAR(static_cast<double>(fast[i]), exact[i], 1e-6);
  }
}

TEST(LocalNormalisation, FlatImagesGiveZeros) {
  for (const float gray : {0.0F, 17.0F, 255.0F}) {
    Tensor<float> image({1, 53, 70, 1});
    image.array() = gray;
    const Tensor<float> z = normalised(image);
    for (Index i = 0; i < z.size(); ++i) ASSERT_EQ(z[i], 0.0F) << gray;
  }
}

TEST(LocalNormalisation, GainAndOffsetOfTheExposureCancel) {
  LocalNormalisationOptions options;
  options.noise_floor = 1e-3;
  const Tensor<double> image = noise({1, 53, 70, 1}, 5);
  Tensor<double> exposed = image.clone();
  exposed.array() = 0.3 * image.array() + 40.0;
  const Tensor<double> a = normalised(image, options);
  const Tensor<double> b = normalised(exposed, options);
  for (Index i = 0; i < a.size(); ++i) ASSERT_NEAR(a[i], b[i], 1e-6);
}

TEST(LocalNormalisation, RefusesPixelsThatAreNoNumbers) {
  Tensor<float> image({1, 20, 20, 1});
  image[211] = std::numeric_limits<float>::quiet_NaN();
  EXPECT_THROW(normalised(image), ContractError);
  image[211] = std::numeric_limits<float>::infinity();
  EXPECT_THROW(normalised(image), ContractError);
}

}  // namespace
}  // namespace imslam::vo
