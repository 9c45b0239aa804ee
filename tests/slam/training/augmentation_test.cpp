#include "slam/training/augmentation.hpp"

#include <gtest/gtest.h>

#include "slam/base/error.hpp"
#include "slam/base/parallel.hpp"
#include "tests/slam/training/samples.hpp"

namespace imslam::training {
namespace {

/// A clean sample, made once.
const Triplet& clean() {
  static const Triplet triplet = quick_generator().make(5);
  return triplet;
}

Triplet augmented(const AugmentationOptions& options, std::uint64_t index, double ramp) {
  Triplet triplet = clean();
  Augmentation(options).apply(index, ramp, triplet);
  return triplet;
}

TEST(Augmentation, RampZeroChangesNothing) {
  for (std::uint64_t i = 0; i < 40; ++i) EXPECT_TRUE(same(augmented({}, i, 0.0), clean())) << i;
}

TEST(Augmentation, ViewsStayWithinWholeGreyLevels) {
  for (std::uint64_t i = 0; i < 60; ++i) {
    const Triplet t = augmented({}, i, 1.0);
    for (const std::vector<float>* view : {&t.left0, &t.right0, &t.left1}) {
      for (const float grey : *view) {
        ASSERT_TRUE(grey >= 0.0F && grey <= 255.0F && grey == std::floor(grey)) << i;
      }
    }
  }
}

TEST(Augmentation, PhotometryLeavesTheTruthAlone) {
  AugmentationOptions options;
  options.occluder_share = 0.0;
  for (std::uint64_t i = 0; i < 20; ++i) {
    Triplet t = augmented(options, i, 1.0);
    EXPECT_NE(t.left0, clean().left0);
    t.left0 = clean().left0;
    t.right0 = clean().right0;
    t.left1 = clean().left1;
    EXPECT_TRUE(same(t, clean())) << i;
  }
}

TEST(Augmentation, DependsOnSeedAndIndexOnly) {
  const Augmentation augmentation({});
  std::vector<Triplet> alone(4, clean());
  std::vector<Triplet> together(4, clean());
  set_thread_count(1);
  parallel_for(4, [&](std::size_t i) { augmentation.apply(30 + i, 0.8, alone[i]); });
  set_thread_count(2);
  parallel_for(4, [&](std::size_t i) { augmentation.apply(30 + i, 0.8, together[i]); });
  set_thread_count(0);
  for (std::size_t i = 4; i-- > 0;) {
    EXPECT_TRUE(same(alone[i], together[i])) << i;
    EXPECT_TRUE(same(alone[i], augmented({}, 30 + i, 0.8))) << i;
  }
  EXPECT_FALSE(same(alone[0], alone[1]));
  AugmentationOptions other;
  other.seed = 2;
  EXPECT_FALSE(same(augmented(other, 30, 0.8), alone[0]));
}

/// The strengths of a view, each divided by what the options allow at most.
std::vector<double> strengths(const ViewDegradation& d, const AugmentationOptions& o) {
  const auto log_share = [](double value, double most) { return std::log(value) / std::log(most); };
  const double gain = d.gain > 1.0F ? log_share(double{d.gain}, o.most_gain)
                                    : log_share(double{d.gain}, o.least_gain);
  return {std::abs(gain),
          std::abs(log_share(double{d.gamma}, o.most_gamma)),
          log_share(double{d.darkness}, o.darkest),
          double{d.vignetting} / o.vignetting,
          double{d.haze} / o.haze,
          std::hypot(d.motion.u, d.motion.v) / o.motion_blur,
          double{d.defocus.sigma} / o.defocus,
          double{d.read_noise} / o.read_noise,
          double{d.shot_noise} / o.shot_noise,
          static_cast<double>(d.hot_pixels) / o.hot_pixels};
}

TEST(Augmentation, StrengthsStayBelowTheRampAndReachIt) {
  const AugmentationOptions options;
  const Augmentation augmentation(options);
  for (const double ramp : {0.3, 1.0}) {
    std::vector<double> most(10, 0.0);
    std::size_t occluders = 0;
    for (std::uint64_t i = 0; i < 1500; ++i) {
      const TripletDegradation d = augmentation.draw(i, ramp, 384, 256);
      occluders += d.occluders.size();
      for (const ViewDegradation* view : {&d.left0, &d.right0, &d.left1}) {
        const std::vector<double> now = strengths(*view, options);
        for (std::size_t k = 0; k < now.size(); ++k) most[k] = std::max(most[k], now[k]);
      }
    }
    for (std::size_t k = 0; k < most.size(); ++k) {
      EXPECT_LE(most[k], ramp + 1e-6) << k;
      EXPECT_GT(most[k], 0.8 * ramp) << k;
    }
    // On average 2.5 in the share of samples that has any.
    EXPECT_NEAR(static_cast<double>(occluders) / 1500, 2.5 * ramp * options.occluder_share, 0.15);
  }
}

TEST(Augmentation, ViewsThatShareACameraOrAnInstantShareItsDefects) {
  const Augmentation augmentation({});
  for (std::uint64_t i = 0; i < 100; ++i) {
    const TripletDegradation d = augmentation.draw(i, 1.0, 384, 256);
    EXPECT_EQ(d.left0.hot_seed, d.left1.hot_seed);
    EXPECT_EQ(d.left0.vignette_x, d.left1.vignette_x);
    EXPECT_EQ(d.left0.motion.u, d.right0.motion.u);
    EXPECT_TRUE(d.left0.gain == 1.0F || d.left1.gain == 1.0F);
    EXPECT_NE(d.noise_seeds[0], d.noise_seeds[1]);
  }
}

TEST(Augmentation, RefusesOptionsThatMakeNoSense) {
  AugmentationOptions options;
  options.darkest = 0.0;
  EXPECT_THROW(Augmentation{options}, InputError);
  options = AugmentationOptions();
  options.haze_share = 1.5;
  EXPECT_THROW(Augmentation{options}, InputError);
  EXPECT_THROW(Augmentation({}).draw(0, 1.5, 384, 256), ContractError);
}

}  // namespace
}  // namespace imslam::training
