#include "tools/bench/matching/experiment.hpp"

#include <gtest/gtest.h>

#include <algorithm>

#include "tests/bench/match_scenes.hpp"
#include "tools/bench/matching/summary.hpp"

namespace imslam::bench {
namespace {

using vo::MatchKind;

/// Knows textured_scene(), but every second point only.
class Oracle final : public Method {
 public:
  std::vector<std::string> names(MatchKind) const override { return {"oracle"}; }
  std::vector<Answer> match(MatchKind kind,
                            const GrayImage&,
                            const GrayImage&,
                            const std::vector<Eigen::Vector2d>& points) const override {
    Answer answer{"oracle", std::vector<PointMatch>(points.size())};
    for (std::size_t i = 0; i < points.size(); i += 2) {
      answer.matches[i].answered = answer.matches[i].accepted = true;
      answer.matches[i].displacement =
          kind == MatchKind::kFlow ? Eigen::Vector2d(3.0, -2.0) : Eigen::Vector2d(-4.0, 9.0);
    }
    return {answer};
  }
};

std::vector<Measurement> measured(const std::vector<Trial>& trials) {
  std::vector<std::unique_ptr<Method>> methods;
  methods.push_back(std::make_unique<Oracle>());
  const DataSet data{"textured", {imslam::testing::textured_scene()}};
  return measure(data, trials, methods, 1);
}

const Condition& condition_named(const std::vector<Condition>& all, const std::string& name) {
  return *std::find_if(all.begin(), all.end(),
                       [&](const Condition& condition) { return condition.name == name; });
}

TEST(Experiment, AnOracleHasNoErrorInAnyKind) {
  const std::vector<Measurement> results = measured({{{"clean", "", {}, nullptr}, 0}});
  ASSERT_EQ(results.size(), 2U);
  for (const Measurement& m : results) {
    const Quality quality = natural_quality(m.results);
    EXPECT_GT(quality.points, 20U) << kind_name(m.kind);
    EXPECT_EQ(quality.mean, 0.0) << kind_name(m.kind);
    EXPECT_NEAR(quality.coverage, 0.5, 0.02);
  }
}

/// The oracle knows nothing of the patches: a point on one of them would be an error.
TEST(Experiment, PointsThatAMovingPatchCoversDoNotCount) {
  const std::vector<Condition> all = conditions();
  const std::vector<Measurement> results =
      measured({{{"clean", "", {}, nullptr}, 0}, {condition_named(all, "moving"), 5}});
  ASSERT_EQ(results.size(), 4U);
  for (const std::size_t i : {0U, 2U}) {
    EXPECT_LT(results[i + 1].results.size(), results[i].results.size());
    EXPECT_EQ(natural_quality(results[i + 1].results).mean, 0.0);
  }
}

}  // namespace
}  // namespace imslam::bench
