#include "slam/plugins/routing/city_features.hpp"

#include <gtest/gtest.h>

#include <cmath>

namespace imslam::routing {
namespace {

constexpr nn::Index kBoxPlaces = 2;  ///< first of all: the only ones that know which way is up

Instance some_cities(int count) {
  Random random(21);
  return random_instance(count, random);
}

/// Turned by a right angle, so that the box around it is as large as before.
Instance turned_moved_and_scaled(Instance instance) {
  for (Point& p : instance.points) p = {5.0 - 7.0 * p.y, -3.0 + 7.0 * p.x};
  return instance;
}

TEST(CityFeatures, DoNotChangeWhereTheFieldIsTurnedMovedAndScaled) {
  const Instance instance = some_cities(40);
  const nn::Tensor<float> there = city_features(instance);
  const nn::Tensor<float> here = city_features(turned_moved_and_scaled(instance));
  for (nn::Index row = 0; row < 40; ++row) {
    for (nn::Index k = kBoxPlaces; k < kCityFeatures; ++k) {
      EXPECT_NEAR(there[row * kCityFeatures + k], here[row * kCityFeatures + k], 1e-5)
          << "city " << row << ", feature " << k;
    }
  }
}

TEST(CityFeatures, StayWithinTheSameRangeHoweverManyCitiesThereAre) {
  for (const int count : {2, 3, 50, 3000}) {
    const nn::Tensor<float> features = city_features(some_cities(count));
    for (nn::Index i = 0; i < features.size(); ++i) {
      EXPECT_LE(std::abs(features[i]), 2.5F) << count << " cities, number " << i;
    }
  }
}

TEST(CityFeatures, AreFiniteForCitiesAtOnePlace) {
  Instance instance;
  instance.points.assign(5, {1.0, 1.0});
  const nn::Tensor<float> features = city_features(instance);
  for (nn::Index i = 0; i < features.size(); ++i) EXPECT_TRUE(std::isfinite(features[i]));
}

}  // namespace
}  // namespace imslam::routing
