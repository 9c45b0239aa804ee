#include "datasets/scale_comparison.hpp"

#include <gtest/gtest.h>

#include "tests/support/tiny_dataset.hpp"

namespace imslam::datasets {
namespace {

using imslam::testing::TinyWorld;

TinyWorld swaying_world() {
  TinyWorld world;
  world.frames = 60;
  return world;
}

/// The true motions of the left camera, their lengths times `scale`.
std::vector<VisualRotation> motions_of(const TinyWorld& world, double scale) {
  std::vector<VisualRotation> motions;
  for (int i = 1; i < world.frames; ++i) {
    const auto T_world_left = [&](int frame) {
      return world.T_world_body(frame / world.frame_rate) * world.T_body_left();
    };
    const lie::SE3d step = T_world_left(i - 1).inverse() * T_world_left(i);
    motions.push_back({world.frame_time_ns(i - 1), world.frame_time_ns(i), step.rotation().log(),
                       scale * step.translation()});
  }
  return motions;
}

TEST(CompareScale, FindsHowMuchTooFarVisionMoves) {
  const TinyWorld world = swaying_world();
  for (const double scale : {0.5, 1.0, 2.0}) {
    const auto fit = compare_scale(motions_of(world, scale), world.imu(), world.T_body_left(), 0.0);
    EXPECT_TRUE(fit.valid);
    EXPECT_NEAR(fit.scale, scale, 0.01 * scale);
    EXPECT_NEAR(fit.gravity, 9.81, 0.05);
  }
}

TEST(CompareScale, TakesBiasAndClockOffsetIntoAccount) {
  const TinyWorld world = swaying_world();
  std::vector<ImuSample> samples = world.imu();
  for (ImuSample& sample : samples) {
    sample.time_ns += 20'000'000;
    sample.linear_acceleration += Eigen::Vector3d(0.2, -0.1, 0.05);
  }
  const auto fit = compare_scale(motions_of(world, 1.3), samples, world.T_body_left(), 0.02);
  EXPECT_TRUE(fit.valid);
  EXPECT_NEAR(fit.scale, 1.3, 0.02);
}

TEST(CompareScale, SurvivesGapsInVisionAndImu) {
  TinyWorld world = swaying_world();
  world.frames = 120;
  auto motions = motions_of(world, 2.0);
  motions.erase(motions.begin() + 20);
  std::vector<ImuSample> samples = world.imu();
  samples.erase(samples.begin() + 420, samples.begin() + 440);
  const auto fit = compare_scale(motions, samples, world.T_body_left(), 0.0);
  EXPECT_NEAR(fit.scale, 2.0, 0.05);
}

TEST(CompareScale, SaysNothingWithoutAcceleration) {
  TinyWorld world = swaying_world();
  world.sway = 0.0;
  EXPECT_FALSE(compare_scale(motions_of(world, 1.0), world.imu(), world.T_body_left(), 0.0).valid);
  EXPECT_FALSE(compare_scale({}, world.imu(), world.T_body_left(), 0.0).valid);
  EXPECT_FALSE(compare_scale(motions_of(world, 1.0), {}, world.T_body_left(), 0.0).valid);
}

}  // namespace
}  // namespace imslam::datasets
