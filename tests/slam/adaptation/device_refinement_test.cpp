#include "slam/adaptation/device_refinement.hpp"

#include <gtest/gtest.h>

#include "slam/system/batch_estimator.hpp"
#include "tests/slam/system/sine_measurements.hpp"

namespace imslam::adaptation {
namespace {

using system::testing::SineWorld;

StereoCamera camera() {
  StereoCamera camera;
  camera.fx = camera.fy = 400.0;
  camera.baseline_m = 0.1;
  camera.T_body_left = {lie::SO3d::exp({0.3, -0.2, 1.2}), Eigen::Vector3d(0.05, 0.02, -0.01)};
  return camera;
}

/// A run whose camera is turned by `turn` against what its calibration says.
system::SlamResult run_with_turned_camera(const Eigen::Vector3d& turn) {
  const SineWorld world;
  system::Measurements measurements = world.measure();
  const lie::SE3d T_body_left = camera().T_body_left;
  const lie::SE3d T_left_stated = {lie::SO3d::exp(turn), Eigen::Vector3d::Zero()};
  // T_body_left_true = T_body_left T; motions of the left camera are carried over by the stated
  // one.
  const lie::SE3d carry = T_body_left * T_left_stated.inverse() * T_body_left.inverse();
  for (RelativeMotion& motion : measurements.odometry) {
    motion.T_body0_body1 = carry * motion.T_body0_body1 * carry.inverse();
  }
  system::SlamOptions options;
  options.pgo.estimate_focal_error = false;
  options.pgo.estimate_disparity_offset = false;
  const auto batch = system::estimate_batch(measurements, {}, options);
  system::SlamResult result;
  result.graph_data = batch.graph;
  result.graph_options = batch.graph_options;
  result.solve = batch.report;
  result.inertial = batch.inertial;
  return result;
}

TEST(CameraRotation, IsFoundFromMotionsThatGyroAndCameraTellDifferently) {
  // Far off the robust kernel bends: a few steps, as the epochs of a fine-tuning take them.
  Eigen::Vector3d left_over(0.004, -0.006, 0.005);
  for (int epoch = 0; epoch < 4; ++epoch) {
    const auto found =
        camera_rotation(run_with_turned_camera(left_over), camera().T_body_left, 0.05);
    ASSERT_TRUE(found);
    EXPECT_LT(found->sigma.maxCoeff(), 1e-3);
    EXPECT_GT(found->sigma.minCoeff(), 0.0);
    left_over -= found->rotation;
  }
  EXPECT_LT(left_over.norm(), 2e-4) << left_over.transpose();
}

TEST(CameraRotation, IsNotMadeUpWhereTheCalibrationIsRight) {
  const auto found =
      camera_rotation(run_with_turned_camera(Eigen::Vector3d::Zero()), camera().T_body_left, 0.05);
  ASSERT_TRUE(found);
  EXPECT_LT(found->rotation.norm(), 1e-4);
}

TEST(CameraRotation, NeedsAnImuToCompareWith) {
  system::SlamResult result = run_with_turned_camera(Eigen::Vector3d::Zero());
  result.inertial = false;
  EXPECT_FALSE(camera_rotation(result, camera().T_body_left, 0.05));
}

/// What the graph is said to have found.
system::SlamResult with_estimates(double focal_sigma) {
  system::SlamResult result = run_with_turned_camera(Eigen::Vector3d::Zero());
  result.disparity_offset_px = {0.15, 0.03};
  result.focal_error = system::Estimate{0.02, focal_sigma};
  result.time_offset_s = system::Estimate{0.004, std::nullopt};
  return result;
}

ImuNoise tactical() {
  ImuNoise noise;
  noise.gyro_bias_sigma = 5e-4;
  return noise;
}

TEST(RefinedDevice, TheScaleOfAPhonesGyroIsNotTakenForTheFocalLength) {
  const ImuNoise phone;
  EXPECT_EQ(refined_device(with_estimates(0.001), {}, camera(), phone, {}, {}).focal_error, 0.0);
  EXPECT_EQ(refined_device(with_estimates(0.001), {}, camera(), {}, {}, {}).focal_error, 0.0);
}

TEST(RefinedDevice, AddsToWhatTheRunAssumed) {
  DeviceCalibration assumed;
  assumed.focal_error = 0.01;
  assumed.time_offset_s = 0.001;
  const auto refined = refined_device(with_estimates(0.001), assumed, camera(), tactical(), {}, {});
  EXPECT_NEAR(refined.focal_error, 1.01 * 1.02 - 1.0, 1e-12);
  EXPECT_EQ(refined.disparity_offset_px, 0.15);
  EXPECT_EQ(refined.time_offset_s, 0.001) << "nobody says how sure the new one is";
}

TEST(RefinedDevice, KeepsWhatTheGraphHardlyKnows) {
  const auto refined = refined_device(with_estimates(0.015), {}, camera(), tactical(), {}, {});
  EXPECT_EQ(refined.focal_error, 0.0);
}

TEST(RefinedDevice, KeepsWhatIsNotToBeRefined) {
  AdaptationOptions options;
  options.calibration = "off";
  DeviceCalibration assumed;
  assumed.disparity_offset_px = 0.5;
  const auto refined =
      refined_device(with_estimates(0.001), assumed, camera(), tactical(), {}, options);
  EXPECT_EQ(refined.disparity_offset_px, 0.5);
  EXPECT_EQ(refined.focal_error, 0.0);
  EXPECT_EQ(refined.camera_rotation, Eigen::Vector3d::Zero());
}

TEST(RefinedDevice, ALearningHeadDoesNotMoveTheCalibrationUnlessAskedTo) {
  system::SlamOptions slam;
  slam.vo.head = "regression";
  AdaptationOptions options;
  const auto refine = [&] {
    return refined_device(with_estimates(0.001), {}, camera(), tactical(), slam, options);
  };
  EXPECT_EQ(refine().disparity_offset_px, 0.0);
  EXPECT_EQ(refine().focal_error, 0.0);
  EXPECT_EQ(refine().camera_rotation, Eigen::Vector3d::Zero());
  options.calibration = "on";
  EXPECT_EQ(refine().disparity_offset_px, 0.15);
}

}  // namespace
}  // namespace imslam::adaptation
