#include "slam/evaluation/errors.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "slam/base/error.hpp"
#include "slam/evaluation/names.hpp"
#include "slam/evaluation/rigid_matrix.hpp"
#include "slam/evaluation/statistics.hpp"
#include "tests/slam/evaluation/paths.hpp"

namespace imslam::evaluation {
namespace {

using testing::disturbed;
using testing::moved;
using testing::some_motion;
using testing::winding_path;

constexpr Relation kAllRelations[] = {Relation::kTranslationPart,    Relation::kRotationPart,
                                      Relation::kFullTransformation, Relation::kRotationAngleDeg,
                                      Relation::kRotationAngleRad,   Relation::kPointDistance};
constexpr DeltaUnit kAllUnits[] = {DeltaUnit::kFrames, DeltaUnit::kMeters, DeltaUnit::kDegrees,
                                   DeltaUnit::kRadians};

DeltaOptions delta_in(DeltaUnit unit, bool all_pairs) {
  DeltaOptions options;
  options.unit = unit;
  options.delta = unit == DeltaUnit::kFrames ? 3.0 : unit == DeltaUnit::kDegrees ? 20.0 : 0.5;
  options.all_pairs = all_pairs;
  return options;
}

PosePath along_x(const std::vector<double>& positions) {
  PosePath path;
  for (const double x : positions) {
    path.poses.push_back(rigid(Eigen::Matrix3d::Identity(), {x, 0, 0}));
  }
  return path;
}

TEST(RotationAngle, IsExactFromTinyToHalfTurns) {
  const Eigen::Vector3d axis = Eigen::Vector3d(1, -2, 3).normalized();
  for (const double angle : {0.0, 1e-12, 1e-7, 1e-3, 1.0, 3.0, kPi - 1e-7, kPi}) {
    EXPECT_NEAR(rotation_angle(Eigen::AngleAxisd(angle, axis).toRotationMatrix()), angle,
                4e-16 + 1e-12 * angle);
  }
}

TEST(AbsoluteErrors, VanishForEqualPaths) {
  const PosePath path = winding_path(40);
  for (const Relation relation : kAllRelations) {
    EXPECT_LT(statistics(absolute_errors(path, path, relation).errors).max, 1e-14);
  }
}

TEST(AbsoluteErrors, MeasureAKnownDifference) {
  const PosePath reference = winding_path(40);
  PosePath estimate = reference;
  const Eigen::Matrix4d step =
      rigid(Eigen::AngleAxisd(0.3, Eigen::Vector3d::UnitY()).toRotationMatrix(), {0.0, 3.0, 4.0});
  for (auto& pose : estimate.poses) pose = pose * step;
  const auto mean = [&](Relation relation) {
    return statistics(absolute_errors(reference, estimate, relation).errors).mean;
  };
  EXPECT_NEAR(mean(Relation::kTranslationPart), 5.0, 1e-12);
  EXPECT_NEAR(mean(Relation::kRotationAngleRad), 0.3, 1e-12);
  EXPECT_NEAR(mean(Relation::kRotationAngleDeg), 0.3 * kDegreesPerRadian, 1e-10);
  EXPECT_NEAR(mean(Relation::kRotationPart), 2.0 * std::sqrt(2.0) * std::sin(0.15), 1e-12);
  EXPECT_NEAR(mean(Relation::kFullTransformation),
              std::sqrt(25.0 + 8.0 * std::sin(0.15) * std::sin(0.15)), 1e-12);
}

TEST(AbsoluteErrors, HaveNoRatio) {
  const PosePath path = winding_path(4);
  EXPECT_THROW(absolute_errors(path, path, Relation::kPointDistanceErrorRatio), InputError);
}

// K5: the choice of either world must not matter to relative errors.
TEST(RelativeErrors, DoNotChangeUnderRigidMotionsOfEitherWorld) {
  const PosePath reference = winding_path(150);
  const PosePath estimate = disturbed(reference);
  const PosePath moved_reference = moved(reference, rigid_inverse(some_motion()));
  const PosePath moved_estimate = moved(estimate, some_motion());
  for (const DeltaUnit unit : kAllUnits) {
    for (const bool all_pairs : {false, true}) {
      for (const Relation relation : kAllRelations) {
        const auto options = delta_in(unit, all_pairs);
        const auto here = relative_errors(reference, estimate, relation, options);
        const auto there = relative_errors(moved_reference, moved_estimate, relation, options);
        ASSERT_EQ(here.poses, there.poses);
        EXPECT_NEAR(statistics(here.errors).rmse, statistics(there.errors).rmse,
                    1e-9 * statistics(here.errors).rmse);
      }
    }
  }
}

TEST(RelativeErrors, OfAScaledPathAreTheMissingShare) {
  const PosePath reference = winding_path(100);
  PosePath estimate = reference;
  for (auto& pose : estimate.poses) pose.topRightCorner<3, 1>() *= 0.9;
  const auto series =
      relative_errors(reference, estimate, Relation::kPointDistanceErrorRatio, DeltaOptions{});
  EXPECT_NEAR(statistics(series.errors).min, 10.0, 1e-9);
  EXPECT_NEAR(statistics(series.errors).max, 10.0, 1e-9);
}

TEST(RelativeErrors, DropPairsWithoutReferenceMotionFromTheRatio) {
  const auto series = relative_errors(along_x({0, 1, 1, 2}), along_x({0, 2, 3, 4}),
                                      Relation::kPointDistanceErrorRatio, DeltaOptions{});
  EXPECT_EQ(series.errors, (std::vector<double>{100.0, 0.0}));
  EXPECT_EQ(series.poses, (std::vector<std::size_t>{1, 3}));
  EXPECT_EQ(series.dropped, 1U);
}

TEST(SelectPairs, InFrames) {
  DeltaOptions options;
  options.delta = 2;
  const PosePath path = along_x({0, 1, 2, 3, 4, 5});
  EXPECT_EQ(select_pairs(path, options), (std::vector<PosePair>{{0, 2}, {2, 4}}));
  options.all_pairs = true;
  EXPECT_EQ(select_pairs(path, options), (std::vector<PosePair>{{0, 2}, {1, 3}, {2, 4}, {3, 5}}));
}

TEST(SelectPairs, InMetersTheFirstStretchOfAChainIsNotMeasured) {
  DeltaOptions options;
  options.delta = 2;
  options.unit = DeltaUnit::kMeters;
  EXPECT_EQ(select_pairs(along_x({0, 1, 2, 3, 4, 5, 6}), options),
            (std::vector<PosePair>{{2, 4}, {4, 6}}));
}

TEST(SelectPairs, InMetersAllPairsKeepToTheTolerance) {
  DeltaOptions options;
  options.delta = 1.0;
  options.unit = DeltaUnit::kMeters;
  options.all_pairs = true;
  EXPECT_EQ(select_pairs(along_x({0, 0.95, 1.2, 2.2, 4.0}), options),
            (std::vector<PosePair>{{0, 1}, {2, 3}}));
  // 1 - 0.5 and 1.5 - 1 are equally near: the first counts, and only if within the tolerance.
  options.relative_tolerance = 0.5;
  EXPECT_EQ(select_pairs(along_x({0, 0.5, 1.5}), options), (std::vector<PosePair>{{0, 1}, {1, 2}}));
}

TEST(SelectPairs, OnTheReferenceIfAsked) {
  DeltaOptions options;
  options.delta = 1.0;
  options.unit = DeltaUnit::kMeters;
  options.all_pairs = true;
  const PosePath reference = along_x({0, 1, 2});
  const PosePath estimate = along_x({0, 10, 20});
  EXPECT_THROW(relative_errors(reference, estimate, Relation::kTranslationPart, options),
               InputError);
  options.pairs_from_reference = true;
  EXPECT_EQ(relative_errors(reference, estimate, Relation::kTranslationPart, options).errors,
            (std::vector<double>{9.0, 9.0}));
}

TEST(DeltaText, WritesNumbersAsEvoDoes) {
  const auto text = [](double delta, DeltaUnit unit) {
    DeltaOptions options;
    options.delta = delta;
    options.unit = unit;
    return delta_text(options);
  };
  EXPECT_EQ(text(10.0, DeltaUnit::kFrames), "delta = 10 (frames)");
  EXPECT_EQ(text(1.0, DeltaUnit::kMeters), "delta = 1.0 (m)");
  EXPECT_EQ(text(0.25, DeltaUnit::kRadians), "delta = 0.25 (rad)");
  EXPECT_EQ(text(20.0, DeltaUnit::kDegrees), "delta = 20.0 (deg)");
}

TEST(EvoTitle, OfARelativeErrorNamesThePairs) {
  DeltaOptions options;
  options.unit = DeltaUnit::kMeters;
  options.all_pairs = true;
  EXPECT_EQ(evo_title(Relation::kTranslationPart, {}, &options, "xy"),
            "RPE w.r.t. translation part (m)\nfor delta = 1.0 (m) using all pairs\n(not aligned)\n"
            "(projected to xy plane)");
}

TEST(DeltaOptions, RejectsWhatHasNoMeaning) {
  const auto rejects = [](double delta, DeltaUnit unit) {
    DeltaOptions options;
    options.delta = delta;
    options.unit = unit;
    try {
      options.validate();
    } catch (const InputError& error) {
      return error.code() == ExitCode::kUsage;
    }
    return false;
  };
  EXPECT_TRUE(rejects(0.0, DeltaUnit::kMeters));
  EXPECT_TRUE(rejects(-1.0, DeltaUnit::kFrames));
  EXPECT_TRUE(rejects(1.5, DeltaUnit::kFrames));
  EXPECT_TRUE(rejects(181.0, DeltaUnit::kDegrees));
  EXPECT_TRUE(rejects(3.2, DeltaUnit::kRadians));
  EXPECT_TRUE(rejects(std::nan(""), DeltaUnit::kMeters));
  EXPECT_FALSE(rejects(180.0, DeltaUnit::kDegrees));
}

}  // namespace
}  // namespace imslam::evaluation
