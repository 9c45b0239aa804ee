#include "slam/evaluation/associate.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "slam/base/error.hpp"
#include "slam/base/random.hpp"
#include "tests/slam/evaluation/paths.hpp"
#include "tests/support/numeric_jacobian.hpp"

namespace imslam::evaluation {
namespace {

using testing::expect_near;
using testing::winding_path;

PosePath at_stamps(const std::vector<double>& stamps) {
  PosePath path;
  path.source = "path";
  for (const double s : stamps) {
    path.stamps_s.push_back(s);
    path.poses.push_back(rigid(Eigen::Matrix3d::Identity(), {s, 0.0, 0.0}));
  }
  return path;
}

bool mentions(const std::vector<std::string>& warnings, const std::string& words) {
  return std::any_of(warnings.begin(), warnings.end(), [&](const std::string& warning) {
    return warning.find(words) != std::string::npos;
  });
}

std::string refusal(const PosePath& reference,
                    const PosePath& estimate,
                    const AssociationOptions& options = {}) {
  try {
    associate(reference, estimate, options);
  } catch (const InputError& error) {
    EXPECT_EQ(error.code(), ExitCode::kEvaluation);
    return error.what();
  }
  ADD_FAILURE() << "accepted";
  return "";
}

/// evo's rule word for word: look at every pose of the other path.
Nearest slow_nearest(double stamp, const std::vector<double>& others, double offset_s) {
  Nearest best{0, std::numeric_limits<double>::infinity()};
  for (std::size_t j = 0; j < others.size(); ++j) {
    const double difference = std::abs((others[j] + offset_s) - stamp);
    if (difference < best.difference_s) best = {j, difference};
  }
  return best;
}

TEST(NearestStamps, EqualsTheExhaustiveSearch) {
  Random random(5);
  for (const bool sorted : {true, false}) {
    std::vector<double> stamps;
    std::vector<double> others;
    // A coarse grid makes ties and repeated stamps frequent; epoch stamps make rounding visible.
    for (int i = 0; i < 300; ++i) stamps.push_back(1.4e9 + 0.005 * double(random.integer(0, 400)));
    for (int i = 0; i < 200; ++i) others.push_back(1.4e9 + 0.01 * double(random.integer(0, 200)));
    if (sorted) std::sort(others.begin(), others.end());
    const auto fast = nearest_stamps(stamps, others, 0.0025);
    for (std::size_t i = 0; i < stamps.size(); ++i) {
      const Nearest slow = slow_nearest(stamps[i], others, 0.0025);
      EXPECT_EQ(fast[i].index, slow.index);
      EXPECT_EQ(fast[i].difference_s, slow.difference_s);
    }
  }
}

TEST(Associate, TheBoundIsInclusive) {
  AssociationOptions options;
  options.max_difference_s = 0.25;
  EXPECT_EQ(associate(at_stamps({0, 1}), at_stamps({0.25, 1.5}), options).estimate.size(), 1U);
}

TEST(Associate, TheOffsetIsAddedToTheEstimateWhicheverIsLonger) {
  AssociationOptions options;
  options.offset_s = 100.0;
  EXPECT_EQ(associate(at_stamps({100, 101, 102}), at_stamps({0, 1}), options).estimate.size(), 2U);
  EXPECT_EQ(associate(at_stamps({100, 101}), at_stamps({0, 1, 2}), options).estimate.size(), 2U);
}

TEST(Associate, CropsTheReferenceOnly) {
  AssociationOptions options;
  options.start_s = 1.0;
  options.end_s = 2.0;
  const auto m = associate(at_stamps({0, 1, 2, 3}), at_stamps({0, 1, 2, 3}), options);
  EXPECT_EQ(m.reference_poses, 2U);
  EXPECT_EQ(m.estimate_poses, 4U);
  EXPECT_EQ(m.reference.stamps_s, (std::vector<double>{1, 2}));
}

TEST(Associate, InterpolatesOnTheGeodesic) {
  PosePath reference;
  for (int i = 0; i < 3; ++i) {
    reference.stamps_s.push_back(0.1 * i);
    reference.poses.push_back(rigid(
        Eigen::AngleAxisd(0.5 * i, Eigen::Vector3d::UnitZ()).toRotationMatrix(), {1.0 * i, 0, 0}));
  }
  PosePath estimate = at_stamps({-0.01, 0.025, 0.1, 0.2, 0.21});
  AssociationOptions options;
  options.interpolate = true;
  const auto m = associate(reference, estimate, options);
  ASSERT_EQ(m.estimate.stamps_s, (std::vector<double>{0.025, 0.1, 0.2}));
  expect_near(
      m.reference.poses[0],
      rigid(Eigen::AngleAxisd(0.125, Eigen::Vector3d::UnitZ()).toRotationMatrix(), {0.25, 0, 0}),
      1e-12);
  expect_near(m.reference.poses[1], reference.poses[1], 0.0);
}

TEST(Associate, DoesNotInterpolateAcrossHoles) {
  AssociationOptions options;
  options.interpolate = true;
  const auto m = associate(at_stamps({0, 0.1, 5, 5.1}), at_stamps({0.05, 2, 5.05}), options);
  EXPECT_EQ(m.estimate.stamps_s, (std::vector<double>{0.05, 5.05}));
}

TEST(Associate, PathsWithoutStampsMustBeEquallyLong) {
  PosePath a = winding_path(5);
  PosePath b = winding_path(6);
  a.stamps_s.clear();
  EXPECT_NE(refusal(a, b).find("has no"), std::string::npos);
  b.stamps_s.clear();
  EXPECT_NE(refusal(a, b).find("trajectories must have same number of poses"), std::string::npos);
}

TEST(Associate, NamesAnotherUnitOfTime) {
  const PosePath seconds = winding_path(100, 0.05, 1.4e9);
  PosePath nanoseconds = seconds;
  nanoseconds.source = "est.txt";
  for (double& s : nanoseconds.stamps_s) s *= 1e9;
  EXPECT_NE(refusal(seconds, nanoseconds).find("est.txt look like nanoseconds"), std::string::npos);

  PosePath short_clock = winding_path(100, 0.05, 3.0);
  PosePath milliseconds = short_clock;
  for (double& s : milliseconds.stamps_s) s *= 1e3;
  EXPECT_NE(refusal(milliseconds, short_clock).find("milliseconds"), std::string::npos);
}

TEST(Associate, WarnsEvenIfBothPathsCountNanoseconds) {
  PosePath path = winding_path(10, 0.05, 1.4e9);
  for (double& s : path.stamps_s) s *= 1e9;
  EXPECT_TRUE(mentions(associate(path, path).warnings, "nanoseconds"));
}

TEST(Associate, NamesTheShiftBetweenClocksThatDoNotOverlap) {
  const std::string reason = refusal(winding_path(50, 0.05, 1.4e9), winding_path(50, 0.05, 0.0));
  EXPECT_NE(reason.find("do not overlap"), std::string::npos);
  EXPECT_NE(reason.find("--t-offset 1.4e+09"), std::string::npos);
}

TEST(Associate, SuggestsTheBoundThatWouldMatch) {
  const PosePath reference = winding_path(100, 0.1, 0.0);
  PosePath estimate = winding_path(100, 0.1, 0.0);
  for (std::size_t i = 0; i < 100; ++i) estimate.stamps_s[i] += i % 2 == 0 ? 0.0 : 0.03;
  const auto m = associate(reference, estimate);
  EXPECT_EQ(m.estimate.size(), 50U);
  EXPECT_TRUE(mentions(m.warnings, "only 50 of 100 poses"));
  EXPECT_TRUE(mentions(m.warnings, "--t-max-diff 0.031 would match"));

  AssociationOptions follow;
  follow.max_difference_s = 0.031;
  EXPECT_EQ(associate(reference, estimate, follow).estimate.size(), 100U);
}

TEST(Associate, WarnsWhenPosesServeTwice) {
  const auto m = associate(at_stamps({0, 1, 2, 3}), at_stamps({0, 0.001, 1}));
  EXPECT_EQ(m.estimate.size(), 3U);
  EXPECT_TRUE(mentions(m.warnings, "serve as partner of more than one"));
}

TEST(Associate, WarnsWhenTheEstimateEndsEarly) {
  const auto m = associate(winding_path(200), winding_path(80));
  EXPECT_DOUBLE_EQ(m.coverage, 1.0);
  EXPECT_NEAR(m.time_coverage, 79.0 / 199.0, 1e-12);
  EXPECT_TRUE(mentions(m.warnings, "of the reference's duration"));
}

TEST(Associate, IsSilentWhenAllIsWell) {
  EXPECT_TRUE(associate(winding_path(200), winding_path(200)).warnings.empty());
}

TEST(AssociationOptions, RejectsImpossibleBounds) {
  AssociationOptions options;
  options.max_difference_s = -1.0;
  EXPECT_THROW(options.validate(), InputError);
  options = {};
  options.start_s = 2.0;
  options.end_s = 1.0;
  EXPECT_THROW(options.validate(), InputError);
}

}  // namespace
}  // namespace imslam::evaluation
