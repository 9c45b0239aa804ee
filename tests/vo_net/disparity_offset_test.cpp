#include "vo_net/disparity_offset.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "tests/vo_net/synthetic_points.hpp"

namespace imslam::vo {
namespace {

/// A frame that measured `value` with standard deviation `sigma`, solved at `solved_at`.
PoseLayerResult frame(double value, double sigma, double solved_at = 0.0, int points = 0) {
  PoseLayerResult result;
  result.valid = true;
  result.disparity_offset = solved_at;
  result.inliers = points;
  result.offset_information = 1.0 / (sigma * sigma);
  result.offset_gradient = -(value - solved_at) / (sigma * sigma);
  return result;
}

TEST(DisparityOffset, SigmaHoldsAlsoWhenScenesDisagree) {
  Random random(31);
  int inside = 0;
  const int runs = 200;
  for (int run = 0; run < runs; ++run) {
    DisparityOffsetEstimator estimator{DisparityOffsetOptions()};
    double scene = 0.0;
    for (int i = 0; i < 400; ++i) {
      if (i % 10 == 0) scene = 0.25 * random.normal();
      estimator.add(frame(0.4 + scene + 0.1 * random.normal(), 0.1));
    }
    const DisparityOffsetEstimate e = estimator.estimate();
    inside += std::abs(e.offset_px - 0.4) < 2.0 * e.sigma_px ? 1 : 0;
    EXPECT_LT(e.sigma_px, 0.1);
  }
  EXPECT_GT(inside, runs * 88 / 100);
}

TEST(DisparityOffset, DoesNotDependOnWhereFramesWereSolved) {
  DisparityOffsetEstimator a{DisparityOffsetOptions()};
  DisparityOffsetEstimator b{DisparityOffsetOptions()};
  Random random(32);
  for (int i = 0; i < 100; ++i) {
    const double value = 0.3 + 0.1 * random.normal();
    a.add(frame(value, 0.1));
    b.add(frame(value, 0.1, 0.02 * i));
  }
  EXPECT_NEAR(a.estimate().offset_px, b.estimate().offset_px, 1e-12);
}

TEST(DisparityOffset, BearsScenesThatAreFarOff) {
  DisparityOffsetEstimator estimator{DisparityOffsetOptions()};
  Random random(33);
  for (int i = 0; i < 300; ++i) {
    const double outlier = i / 10 % 10 == 0 ? 4.0 : 0.0;
    estimator.add(frame(0.2 + outlier + 0.05 * random.normal(), 0.1));
  }
  EXPECT_NEAR(estimator.estimate().offset_px, 0.2, 0.15);
}

TEST(DisparityOffset, SaysNothingBeforeItHasSeenSomething) {
  DisparityOffsetEstimator estimator{DisparityOffsetOptions()};
  estimator.add(PoseLayerResult());  // not valid
  PoseLayerResult at_rest;
  at_rest.valid = true;
  estimator.add(at_rest);  // no information
  EXPECT_EQ(estimator.estimate().offset_px, 0.0);
  EXPECT_EQ(estimator.estimate().sigma_px, DisparityOffsetOptions().prior_sigma);
  EXPECT_EQ(estimator.estimate().frames, 0);
}

TEST(DisparityOffset, WhatBadMatchesShareIsNotTakenForAnOffset) {
  DisparityOffsetOptions options;
  options.systematic = 0.03;
  options.exact = 0.0;
  DisparityOffsetEstimator estimator{options};
  Random random(35);
  for (int i = 0; i < 200; ++i) estimator.add(frame(-0.3 + 0.4 * random.normal(), 0.4, 0.0, 600));
  EXPECT_LT(std::abs(estimator.estimate().offset_px), 0.15);
  EXPECT_GT(estimator.estimate().sigma_px, 0.15);
}

TEST(DisparityOffset, ClearScenesDecide) {
  DisparityOffsetEstimator estimator{DisparityOffsetOptions()};
  Random random(36);
  for (int i = 0; i < 200; ++i) {
    const bool blurred = i >= 100;
    const double sigma = blurred ? 0.4 : 0.04;
    const double value = (blurred ? -0.3 : 0.1) + sigma * random.normal();
    estimator.add(frame(value, sigma, 0.0, 600));
  }
  EXPECT_NEAR(estimator.estimate().offset_px, 0.1, 0.03);
  EXPECT_LT(estimator.estimate().sigma_px, 0.05);
}

/// Two hundred frames that all say the same but for their noise.
DisparityOffsetEstimate estimate_of(double value,
                                    double systematic,
                                    std::uint64_t seed,
                                    double exact = 0.5) {
  DisparityOffsetOptions options;
  options.systematic = systematic;
  options.exact = exact;
  DisparityOffsetEstimator estimator{options};
  Random random(seed);
  for (int i = 0; i < 200; ++i) estimator.add(frame(value + 0.1 * random.normal(), 0.1, 0.0, 400));
  return estimator.estimate();
}

TEST(DisparityOffset, OneNotSurelyThereIsTakenForNothing) {
  // known to 0.015 * 0.1 * sqrt(400) = 0.03 px
  EXPECT_LT(std::abs(estimate_of(0.03, 0.015, 37).offset_px), 0.015);
  EXPECT_NEAR(estimate_of(0.15, 0.015, 38).offset_px, estimate_of(0.15, 0.015, 38, 0.0).offset_px,
              0.002);
  const DisparityOffsetEstimate doubtful = estimate_of(0.075, 0.015, 39);
  EXPECT_GT(doubtful.offset_px, 0.015);
  EXPECT_LT(doubtful.offset_px, 0.065);
  EXPECT_GT(doubtful.sigma_px, estimate_of(0.15, 0.015, 40).sigma_px);
}

TEST(DisparityOffset, ExactCamerasComeOutBetterAndOthersHardlyWorse) {
  Random random(41);
  const auto error = [&](double offset, double exact) {
    DisparityOffsetOptions options;
    options.exact = exact;
    double squares = 0.0;
    Random draws = random.fork(7);
    for (int run = 0; run < 100; ++run) {
      DisparityOffsetEstimator estimator{options};
      const double shared = 0.03 * draws.normal();
      for (int i = 0; i < 40; ++i) {
        estimator.add(frame(offset + shared + 0.1 * draws.normal(), 0.1, 0.0, 400));
      }
      squares += std::pow(estimator.estimate().offset_px - offset, 2);
    }
    return std::sqrt(squares / 100.0);
  };
  EXPECT_LT(error(0.0, 0.5), 0.6 * error(0.0, 0.0));
  EXPECT_LT(error(0.2, 0.5), 1.05 * error(0.2, 0.0));
  EXPECT_LT(error(0.06, 0.5), 1.6 * error(0.06, 0.0));  // what it costs at its worst
}

TEST(DisparityOffset, LongRunsKeepTheirPrecision) {
  DisparityOffsetEstimator estimator{DisparityOffsetOptions()};
  Random random(34);
  for (int i = 0; i < 50000; ++i) estimator.add(frame(0.1 + 0.2 * random.normal(), 0.2));
  EXPECT_NEAR(estimator.estimate().offset_px, 0.1, 0.01);
  EXPECT_EQ(estimator.estimate().frames, 50000);
}

TEST(DisparityOffset, MotionsCanBeCorrectedAfterwards) {
  Random random(35);
  const StereoCamera camera = testing::test_camera();
  const Correspondences c = testing::synthetic_correspondences(camera, testing::test_motion(), 200,
                                                               {0.05, 0.05, 0.3}, random);
  const PoseLayerResult raw = solve_pose(c, camera, {});
  const PoseLayerResult corrected = solve_pose(c, camera, {}, {}, 0.3);
  RelativeMotion motion;
  motion.T_body0_body1 = raw.T_body0_body1;
  motion.J_disparity_offset = raw.J_disparity_offset;
  const RelativeMotion shifted = with_disparity_offset(motion, 0.3);
  const double before = (raw.T_body0_body1.inverse() * corrected.T_body0_body1).log().norm();
  const double after = (shifted.T_body0_body1.inverse() * corrected.T_body0_body1).log().norm();
  EXPECT_LT(after, 0.2 * before);
  EXPECT_EQ(shifted.disparity_offset, 0.3);
}

}  // namespace
}  // namespace imslam::vo
