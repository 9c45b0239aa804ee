#include "slam/evaluation/align.hpp"

#include <gtest/gtest.h>

#include "slam/base/error.hpp"
#include "slam/evaluation/errors.hpp"
#include "slam/evaluation/statistics.hpp"
#include "tests/slam/evaluation/paths.hpp"
#include "tests/support/numeric_jacobian.hpp"

namespace imslam::evaluation {
namespace {

using testing::disturbed;
using testing::expect_near;
using testing::moved;
using testing::some_motion;
using testing::winding_path;

double rmse(const PosePath& reference, const PosePath& estimate) {
  return statistics(absolute_errors(reference, estimate, Relation::kTranslationPart).errors).rmse;
}

double aligned_rmse(const PosePath& reference, const PosePath& estimate, Alignment kind) {
  return rmse(reference, align(reference, estimate, {kind}).estimate);
}

TEST(Align, Se3FindsTheMotionBetweenTwoCopies) {
  const PosePath path = winding_path(100);
  const AlignedPath aligned = align(moved(path, some_motion()), path, {Alignment::kSe3});
  expect_near(aligned.transform.matrix(), some_motion(), 1e-12);
  for (std::size_t i = 0; i < path.size(); ++i) {
    expect_near(aligned.estimate.poses[i], some_motion() * path.poses[i], 1e-12);
  }
}

TEST(Align, Sim3FindsTheScale) {
  const PosePath reference = winding_path(100);
  PosePath shrunk = moved(reference, some_motion());
  for (auto& pose : shrunk.poses) pose.topRightCorner<3, 1>() *= 0.25;
  const AlignedPath aligned = align(reference, shrunk, {Alignment::kSim3});
  EXPECT_NEAR(aligned.transform.scale, 4.0, 1e-12);
  EXPECT_LT(rmse(reference, aligned.estimate), 1e-12);
}

TEST(Align, ScaleOnlyLeavesOrientationAndOrigin) {
  const PosePath reference = winding_path(100);
  PosePath shrunk = reference;
  for (auto& pose : shrunk.poses) pose.topRightCorner<3, 1>() *= 0.25;
  const AlignedPath aligned = align(reference, shrunk, {Alignment::kScale});
  EXPECT_LT(rmse(reference, aligned.estimate), 1e-12);
  expect_near(aligned.estimate.poses[7].topLeftCorner<3, 3>(),
              reference.poses[7].topLeftCorner<3, 3>(), 1e-15);
}

TEST(Align, OriginPutsTheFirstPoseOntoTheFirst) {
  const PosePath reference = winding_path(50);
  const PosePath estimate = disturbed(moved(reference, some_motion()));
  const AlignedPath aligned = align(reference, estimate, {Alignment::kOrigin});
  expect_near(aligned.estimate.poses[0], reference.poses[0], 1e-12);
}

TEST(Align, NoOtherRigidMotionFitsBetterThanSe3) {
  const PosePath reference = winding_path(120);
  const PosePath estimate = disturbed(moved(reference, some_motion()), 0.1);
  const AlignedPath best = align(reference, estimate, {Alignment::kSe3});
  for (int axis = 0; axis < 6; ++axis) {
    for (const double step : {-1e-3, 1e-3}) {
      lie::SE3d::Tangent tau = lie::SE3d::Tangent::Zero();
      tau(axis) = step;
      const PosePath nudged = moved(best.estimate, lie::SE3d::exp(tau).matrix());
      EXPECT_GT(rmse(reference, nudged), rmse(reference, best.estimate));
    }
  }
}

TEST(Align, PosYawFindsHeadingAndPositionButNoTilt) {
  const PosePath reference = winding_path(100);
  const Eigen::Matrix4d yaw_only =
      rigid(Eigen::AngleAxisd(-2.5, Eigen::Vector3d::UnitZ()).toRotationMatrix(), {4.0, 5.0, -6.0});
  EXPECT_LT(aligned_rmse(reference, moved(reference, yaw_only), Alignment::kPosYaw), 1e-12);

  const Eigen::Matrix4d tilted =
      rigid(Eigen::AngleAxisd(0.1, Eigen::Vector3d::UnitX()).toRotationMatrix(), {0, 0, 0});
  const PosePath leaning = moved(reference, tilted);
  EXPECT_LT(aligned_rmse(reference, leaning, Alignment::kSe3), 1e-12);
  EXPECT_GT(aligned_rmse(reference, leaning, Alignment::kPosYaw), 0.05);
}

TEST(Align, NoOtherHeadingFitsBetterThanPosYaw) {
  const PosePath reference = winding_path(120);
  const PosePath best = align(reference, disturbed(reference, 0.1), {Alignment::kPosYaw}).estimate;
  for (const double angle : {-1e-3, 1e-3}) {
    const Eigen::Matrix4d turn =
        rigid(Eigen::AngleAxisd(angle, Eigen::Vector3d::UnitZ()).toRotationMatrix(), {0, 0, 0});
    const PosePath nudged = moved(best, turn);
    const Points x = positions_of(nudged);
    const Points y = positions_of(reference);
    Eigen::Vector3d shift = Eigen::Vector3d::Zero();
    for (std::size_t i = 0; i < x.size(); ++i) shift += (y[i] - x[i]) / double(x.size());
    EXPECT_GT(rmse(reference, moved(nudged, rigid(Eigen::Matrix3d::Identity(), shift))),
              rmse(reference, best));
  }
}

TEST(Align, PosYawTurnsAboutTheVerticalsOfBothWorlds) {
  const PosePath reference = winding_path(100);
  // The estimate's world has y down, as a camera's: its vertical is -y.
  const Eigen::Matrix3d R_camera_world =
      Eigen::AngleAxisd(kPi / 2, Eigen::Vector3d::UnitX()).toRotationMatrix();
  const Eigen::Matrix3d turn = Eigen::AngleAxisd(0.8, Eigen::Vector3d::UnitZ()).matrix();
  const PosePath estimate = moved(reference, rigid(R_camera_world * turn, {1, 2, 3}));
  AlignmentOptions options{Alignment::kPosYaw};
  options.up_estimate = R_camera_world * Eigen::Vector3d::UnitZ();
  EXPECT_LT(rmse(reference, align(reference, estimate, options).estimate), 1e-12);
}

TEST(Align, FirstNIgnoresWhatComesAfter) {
  const PosePath reference = winding_path(100);
  PosePath estimate = moved(reference, some_motion());
  for (std::size_t i = 50; i < 100; ++i) estimate.poses[i](0, 3) += 100.0;
  AlignmentOptions options{Alignment::kSe3};
  options.first = 50;
  const AlignedPath aligned = align(reference, estimate, options);
  expect_near(aligned.transform.matrix() * some_motion(), Eigen::Matrix4d::Identity(), 1e-10);
}

TEST(Align, RefusesStraightLinesWhereverTheyLie) {
  for (const double far : {0.0, 1e3, 1e6}) {
    PosePath line;
    for (int i = 0; i < 30; ++i) {
      line.poses.push_back(
          rigid(Eigen::Matrix3d::Identity(),
                Eigen::Vector3d(far, -far, far) + 0.1 * i * Eigen::Vector3d(1, 2, 3)));
    }
    try {
      align(line, line, {Alignment::kSe3});
      ADD_FAILURE() << "accepted a line at " << far;
    } catch (const InputError& error) {
      EXPECT_STREQ(error.what(), "Degenerate covariance rank, Umeyama alignment is not possible");
      EXPECT_EQ(error.code(), ExitCode::kEvaluation);
    }
  }
}

TEST(Align, RefusesIdenticalPositionsAndTwoPoses) {
  PosePath still;
  still.poses.assign(20, some_motion());
  EXPECT_THROW(align(still, still, {Alignment::kSe3}), InputError);
  const PosePath two = winding_path(2);
  EXPECT_THROW(align(two, two, {Alignment::kSim3}), InputError);
}

}  // namespace
}  // namespace imslam::evaluation
