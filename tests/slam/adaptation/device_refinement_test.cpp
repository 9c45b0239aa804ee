#include "slam/adaptation/device_refinement.hpp"

#include <gtest/gtest.h>

namespace imslam::adaptation {
namespace {

/// What the graph is said to have found.
system::SlamResult with_estimates(double focal_sigma) {
  system::SlamResult result;
  result.solve.converged = true;
  result.inertial = true;
  result.camera_rotation =
      system::VectorEstimate{{0.004, -0.006, 0.005}, Eigen::Vector3d(0.001, 0.009, 0.001)};
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
  EXPECT_EQ(refined_device(with_estimates(0.001), {}, phone, {}, {}).focal_error, 0.0);
  EXPECT_EQ(refined_device(with_estimates(0.001), {}, {}, {}, {}).focal_error, 0.0);
}

TEST(RefinedDevice, AddsToWhatTheRunAssumed) {
  DeviceCalibration assumed;
  assumed.focal_error = 0.01;
  assumed.time_offset_s = 0.001;
  assumed.camera_rotation = {0.001, 0.001, 0.0};
  const auto refined = refined_device(with_estimates(0.001), assumed, tactical(), {}, {});
  EXPECT_NEAR(refined.focal_error, 1.01 * 1.02 - 1.0, 1e-12);
  EXPECT_EQ(refined.disparity_offset_px, 0.15);
  EXPECT_NEAR(refined.camera_rotation.x(), 0.005, 1e-12);
  EXPECT_EQ(refined.camera_rotation.y(), 0.001) << "hardly known";
  EXPECT_NEAR(refined.camera_rotation.z(), 0.005, 1e-12);
  EXPECT_EQ(refined.time_offset_s, 0.001) << "nobody says how sure the new one is";
}

TEST(RefinedDevice, KeepsWhatTheGraphHardlyKnows) {
  const auto refined = refined_device(with_estimates(0.015), {}, tactical(), {}, {});
  EXPECT_EQ(refined.focal_error, 0.0);
}

TEST(RefinedDevice, WhatHardlyDiffersIsNoNews) {
  system::SlamResult result = with_estimates(0.002);
  result.focal_error->value = 0.003;
  result.disparity_offset_px.value = 0.05;
  EXPECT_EQ(refined_device(result, {}, tactical(), {}, {}).focal_error, 0.0);
  EXPECT_EQ(refined_device(result, {}, tactical(), {}, {}).disparity_offset_px, 0.0);
  DeviceCalibration assumed;
  assumed.disparity_offset_px = -0.1;
  EXPECT_EQ(refined_device(result, assumed, tactical(), {}, {}).disparity_offset_px, 0.05);
}

TEST(RefinedDevice, KeepsWhatIsNotToBeRefined) {
  AdaptationOptions options;
  options.calibration = "off";
  DeviceCalibration assumed;
  assumed.disparity_offset_px = 0.5;
  const auto refined = refined_device(with_estimates(0.001), assumed, tactical(), {}, options);
  EXPECT_EQ(refined.disparity_offset_px, 0.5);
  EXPECT_EQ(refined.focal_error, 0.0);
  EXPECT_EQ(refined.camera_rotation, Eigen::Vector3d::Zero());
}

TEST(RefinedDevice, ALearningHeadDoesNotMoveTheCalibrationUnlessAskedTo) {
  system::SlamOptions slam;
  slam.vo.head = "regression";
  AdaptationOptions options;
  const auto refine = [&] {
    return refined_device(with_estimates(0.001), {}, tactical(), slam, options);
  };
  EXPECT_EQ(refine().disparity_offset_px, 0.0);
  EXPECT_EQ(refine().focal_error, 0.0);
  EXPECT_EQ(refine().camera_rotation, Eigen::Vector3d::Zero());
  options.calibration = "on";
  EXPECT_EQ(refine().disparity_offset_px, 0.15);
}

}  // namespace
}  // namespace imslam::adaptation
