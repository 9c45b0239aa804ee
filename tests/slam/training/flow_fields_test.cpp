#include "slam/training/flow_fields.hpp"

#include <gtest/gtest.h>

#include "slam/base/error.hpp"
#include "slam/training/flow_scene.hpp"

namespace imslam::training {
namespace {

FlowFieldOptions exact_fields() {
  FlowFieldOptions options;
  options.least_noise = options.most_noise = 1e-6;
  options.with_outliers = 0.0;
  options.with_movers = 0.0;
  return options;
}

TEST(FlowFields, MatchesAreWhatTheTrueMotionMakesOfThePoints) {
  const FlowFieldGenerator generator(exact_fields());
  std::size_t points = 0;
  for (std::uint64_t i = 0; i < 40; ++i) {
    const FlowField field = generator.make(i);
    for (const vo::Correspondence& c : field.correspondences) {
      if (c.disparity0 < 1e-2) continue;  // sky: its noise is as large
      const Eigen::Vector3d p_left0 =
          field.camera.back_project({c.left0.x(), c.left0.y(), c.disparity0});
      const Eigen::Vector3d seen = field.camera.project(field.T_left0_left1.inverse() * p_left0);
      EXPECT_LT((seen.head<2>() - c.left1).norm(), 0.02);
      EXPECT_NEAR(seen.z(), c.disparity1, 1e-3 * (1.0 + seen.z()));
      ++points;
    }
  }
  EXPECT_GT(points, 4000U);
}

TEST(FlowFields, ManyKindsOfMotionComeUp) {
  const FlowFieldGenerator generator({});
  int still = 0;
  int forward = 0;
  int usable = 0;
  for (std::uint64_t i = 0; i < 400; ++i) {
    const FlowField field = generator.make(i);
    const Eigen::Vector3d p = field.T_left0_left1.translation();
    if (p.norm() == 0.0) ++still;
    if (p.norm() > 0.0 && p.normalized().z() > 0.98) ++forward;
    if (field.correspondences.size() >= 30) ++usable;
    EXPECT_LE(field.correspondences.size(), 1200U);
  }
  EXPECT_GT(still, 4);
  EXPECT_LT(still, 50);
  EXPECT_GT(forward, 80);
  EXPECT_GT(usable, 340);
}

TEST(FlowFields, AFieldDependsOnItsNumberAndTheSeedAlone) {
  FlowFieldOptions options;
  const FlowFieldGenerator generator(options);
  generator.make(3);
  const FlowField a = generator.make(7);
  const FlowField b = FlowFieldGenerator(options).make(7);
  ASSERT_EQ(a.correspondences.size(), b.correspondences.size());
  for (std::size_t i = 0; i < a.correspondences.size(); ++i) {
    EXPECT_EQ(a.correspondences[i].left1, b.correspondences[i].left1);
  }
  options.seed = 2;
  const FlowField other = FlowFieldGenerator(options).make(7);
  EXPECT_NE(a.T_left0_left1.translation(), other.T_left0_left1.translation());
}

TEST(FlowFields, OptionsOutOfBoundsAreNamed) {
  FlowFieldOptions options;
  options.most_outliers = 2.0;
  EXPECT_THROW(FlowFieldGenerator{options}, InputError);
}

TEST(FlowScene, ARoomIsClosedOnAllSides) {
  Random random(1);
  const FlowScene room(FlowScene::Kind::kRoom, random);
  for (int i = 0; i < 200; ++i) {
    const auto hit = room.cast(random.normal3());
    ASSERT_TRUE(hit.has_value());
    EXPECT_GT(hit->distance, 0.0);
  }
}

}  // namespace
}  // namespace imslam::training
