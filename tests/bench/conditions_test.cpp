#include "tools/bench/matching/conditions.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <string>

#include "tests/bench/match_scenes.hpp"

namespace imslam::bench {
namespace {

using imslam::testing::textured_scene;

double mean_change(const std::vector<float>& a, const std::vector<float>& b) {
  double sum = 0.0;
  for (std::size_t i = 0; i < a.size(); ++i) sum += std::abs(double{a[i]} - double{b[i]});
  return sum / static_cast<double>(a.size());
}

TEST(Conditions, GrowWithTheirSeverityAndGiveWholeGreyLevels) {
  const MatchScene scene = textured_scene();
  for (const Condition& condition : conditions()) {
    double before = 0.0;
    for (const int severity : {1, 3, 5}) {
      const MatchScene worse = spoiled(scene, condition, severity, Random(3));
      const double change = mean_change(worse.views.left1, scene.views.left1);
      EXPECT_GT(change, before) << condition.name << ' ' << severity;
      before = change;
      for (const float grey : worse.views.left1) {
        EXPECT_EQ(grey, std::round(grey));
        EXPECT_TRUE(grey >= 0.0F && grey <= 255.0F);
      }
    }
  }
}

TEST(Conditions, AreTheSameForTheSameSeed) {
  const MatchScene scene = textured_scene();
  for (const Condition& condition : conditions()) {
    const MatchScene a = spoiled(scene, condition, 3, Random(3));
    const MatchScene b = spoiled(scene, condition, 3, Random(3));
    const MatchScene c = spoiled(scene, condition, 3, Random(5));
    EXPECT_EQ(a.views.left1, b.views.left1);
    EXPECT_EQ(a.views.flow_u, b.views.flow_u);
    const std::string name = condition.name;
    const bool leaves_nothing_to_chance = name == "brighter" || name == "darker";
    EXPECT_EQ(a.views.left1 == c.views.left1, leaves_nothing_to_chance) << name;
  }
}

TEST(Conditions, OnlyMovingPatchesChangeTheTruth) {
  const MatchScene scene = textured_scene();
  for (const Condition& condition : conditions()) {
    const MatchScene worse = spoiled(scene, condition, 5, Random(3));
    const bool same = worse.views.disparity == scene.views.disparity &&
                      worse.views.flow_u == scene.views.flow_u &&
                      worse.views.flow_state == scene.views.flow_state;
    EXPECT_EQ(same, std::string(condition.name) != "moving") << condition.name;
  }
}

TEST(Conditions, TheExposureStepLeavesTheFirstLeftImageAlone) {
  const MatchScene scene = textured_scene();
  const std::vector<Condition> all = conditions();
  const auto exposure = std::find_if(all.begin(), all.end(), [](const Condition& condition) {
    return std::string(condition.name) == "brighter";
  });
  const MatchScene worse = spoiled(scene, *exposure, 3, Random(3));
  EXPECT_LT(mean_change(worse.views.left0, scene.views.left0), 0.5);  // rounding
  EXPECT_GT(mean_change(worse.views.right0, scene.views.right0), 30.0);
  EXPECT_GT(mean_change(worse.views.left1, scene.views.left1), 30.0);
}

}  // namespace
}  // namespace imslam::bench
