#include "slam/system/batch_estimator.hpp"

#include <gtest/gtest.h>

#include <algorithm>

#include "tests/slam/system/sine_measurements.hpp"

namespace imslam::system {
namespace {

using testing::SineWorld;
using testing::trajectory_of;

const Estimate kRectified{0.0, 2.0};  // what vision knows of the disparity offset

void erase_odometry(Measurements& measurements, double from_s, double to_s) {
  auto& odometry = measurements.odometry;
  const auto inside = [&](const RelativeMotion& motion) {
    return motion.time1_ns > imu::testing::stamp(from_s) &&
           motion.time0_ns < imu::testing::stamp(to_s);
  };
  odometry.erase(std::remove_if(odometry.begin(), odometry.end(), inside), odometry.end());
}

TEST(EstimateBatch, RecoversTheTruthFromPerfectMeasurements) {
  const SineWorld world;
  const auto estimate = estimate_batch(world.measure(), {}, {});
  EXPECT_TRUE(estimate.inertial);
  EXPECT_TRUE(estimate.report.converged) << estimate.report.reason;
  EXPECT_LT(world.largest_error(trajectory_of(estimate.graph.states)), 1e-3);
}

TEST(EstimateBatch, StandsUprightAtTheOrigin) {
  const SineWorld world;
  const auto estimate = estimate_batch(world.measure(), {}, {});
  const auto& first = estimate.graph.states.front().nav.T_world_body;
  EXPECT_LT(first.translation().norm(), 1e-6);
  const Eigen::Vector3d up_truth =
      world.pose(estimate.graph.states.front().time_ns).rotation().inverse() *
      Eigen::Vector3d::UnitZ();
  const Eigen::Vector3d up = first.rotation().inverse() * Eigen::Vector3d::UnitZ();
  EXPECT_LT((up - up_truth).norm(), 2e-3);
}

/// Perfect vision, an accelerometer with a bias, and what a correction believes about it.
BatchEstimate with_belief(double bias, double believed, double sigma) {
  const SineWorld world;
  Measurements measurements = world.measure();
  for (ImuSample& sample : measurements.imu) sample.linear_acceleration.y() += bias;
  measurements.bias_beliefs.push_back({4, measurements.times_ns[10], believed, sigma});
  return estimate_batch(measurements, {}, {});
}

double accel_bias_y(const BatchEstimate& estimate) {
  return estimate.graph.states[10].bias.accel.y();
}

TEST(EstimateBatch, AFirmBeliefAboutABiasIsKept) {
  EXPECT_NEAR(accel_bias_y(with_belief(0.15, 0.15, 1e-4)), 0.15, 1e-3);
  EXPECT_NEAR(accel_bias_y(with_belief(0.15, 0.18, 1e-5)), 0.18, 1e-3);
}

TEST(EstimateBatch, AWrongBeliefThatDoubtsItselfIsOverruled) {
  EXPECT_NEAR(accel_bias_y(with_belief(0.15, -0.3, 0.5)), 0.15, 2e-2);
}

TEST(EstimateBatch, FindsBiasesAndTheTimeOffset) {
  SineWorld world;
  world.time_offset_s = 0.008;
  Measurements measurements = world.measure();
  const ImuBias bias{{0.02, -0.03, 0.07}, {0.1, -0.05, 0.08}};
  for (ImuSample& sample : measurements.imu) {
    sample.angular_velocity += bias.gyro;
    sample.linear_acceleration += bias.accel;
  }
  const auto estimate = estimate_batch(measurements, {}, {});
  ASSERT_TRUE(estimate.time_offset_s.has_value());
  EXPECT_NEAR(estimate.time_offset_s->value, 0.008, 5e-4);
  const ImuBias& found = estimate.graph.states.back().bias;
  EXPECT_LT((found.gyro - bias.gyro).norm(), 1e-3);
  EXPECT_LT((found.accel - bias.accel).norm(), 2e-2);
  EXPECT_LT(world.largest_error(trajectory_of(estimate.graph.states)), 3e-3);
}

TEST(EstimateBatch, HoldsTheExpectedTimeOffsetWhereNoneIsEstimated) {
  SineWorld world;
  world.time_offset_s = 0.3;
  SlamOptions options;
  options.system.time_offset_s = 0.3;
  options.pgo.estimate_time_offset = false;
  const auto estimate = estimate_batch(world.measure(), kRectified, options);
  ASSERT_TRUE(estimate.time_offset_s.has_value());
  EXPECT_EQ(estimate.time_offset_s->value, 0.3);
  EXPECT_LT(world.largest_error(trajectory_of(estimate.graph.states)), 1e-3);
}

TEST(EstimateBatch, TheImuBridgesASecondWithoutVision) {
  const SineWorld world;
  Measurements measurements = world.measure();
  erase_odometry(measurements, 2.5, 3.5);
  const auto estimate = estimate_batch(measurements, {}, {});
  EXPECT_EQ(estimate.graph.states.size(), measurements.times_ns.size());
  EXPECT_TRUE(std::all_of(estimate.covered.begin(), estimate.covered.end(),
                          [](bool covered) { return covered; }));
  EXPECT_LT(world.largest_error(trajectory_of(estimate.graph.states)), 0.02);
}

TEST(EstimateBatch, WithoutImuAHoleIsBridgedAndFlagged) {
  const SineWorld world;
  Measurements measurements = world.measure();
  measurements.imu.clear();
  erase_odometry(measurements, 2.5, 2.6);
  const auto estimate = estimate_batch(measurements, {}, {});
  EXPECT_FALSE(estimate.inertial);
  EXPECT_EQ(std::count(estimate.covered.begin(), estimate.covered.end(), false), 2);
  for (const pgo::State& state : estimate.graph.states) {
    EXPECT_TRUE(state.nav.T_world_body.matrix().allFinite());
  }
  EXPECT_LT(world.largest_error(trajectory_of(estimate.graph.states)), 0.2);
}

TEST(EstimateBatch, AnImuInUnitsOfGIsNotUsedAndTheReasonIsGiven) {
  const SineWorld world;
  Measurements measurements = world.measure();
  for (ImuSample& sample : measurements.imu) sample.linear_acceleration /= 9.81;
  const auto estimate = estimate_batch(measurements, {}, {});
  EXPECT_FALSE(estimate.inertial);
  ASSERT_FALSE(estimate.warnings.empty());
  EXPECT_NE(estimate.warnings.front().find("IMU not used"), std::string::npos);
  EXPECT_LT(world.largest_error(trajectory_of(estimate.graph.states)), 1e-3);
}

TEST(EstimateBatch, TheDisparityOffsetScalesTheMotionsThatDependOnIt) {
  const SineWorld world;
  Measurements measurements = world.measure();
  // As if every step were seen 1 % too short because of an offset of 0.5 px.
  for (RelativeMotion& motion : measurements.odometry) {
    const Eigen::Vector3d t = motion.T_body0_body1.translation();
    const auto& R = motion.T_body0_body1.rotation();
    motion.J_disparity_offset.head<3>() = R.inverse() * Eigen::Vector3d(0.02 * t);
    motion.T_body0_body1 = lie::SE3d(R, 0.99 * t);
  }
  const auto estimate = estimate_batch(measurements, kRectified, {});
  EXPECT_NEAR(estimate.disparity_offset_px.value, 0.5, 0.1);
  EXPECT_LT(world.largest_error(trajectory_of(estimate.graph.states)), 5e-3);
}

TEST(EstimateBatch, TheGyroTellsHowFarTheFocalLengthIsOff) {
  const SineWorld world;
  Measurements measurements = world.measure();
  // A focal length 2 % too short makes turns 2 % too large.
  for (RelativeMotion& motion : measurements.odometry) {
    const Eigen::Vector3d turn = motion.T_body0_body1.rotation().log();
    motion.J_focal_error.tail<3>() = -turn;
    motion.T_body0_body1 =
        lie::SE3d(lie::SO3d::exp(1.02 * turn), motion.T_body0_body1.translation());
  }
  const auto estimate = estimate_batch(measurements, kRectified, {});
  ASSERT_TRUE(estimate.focal_error.has_value());
  EXPECT_NEAR(estimate.focal_error->value, 0.02, 0.002);
  ASSERT_TRUE(estimate.focal_error->sigma.has_value());
  EXPECT_LT(*estimate.focal_error->sigma, 0.5 * SlamOptions().system.focal_error_prior);
  EXPECT_NEAR(estimate.focal_error->value, 0.02, 4.0 * *estimate.focal_error->sigma);
}

/// Measured through a camera that is turned by `turn` against what its calibration says.
Measurements through_turned_camera(const SineWorld& world, const Eigen::Vector3d& turn) {
  Measurements measurements = world.measure();
  measurements.T_body_left = {lie::SO3d::exp({0.3, -0.2, 1.2}), {0.05, 0.02, -0.01}};
  const lie::SE3d T_left_stated = {lie::SO3d::exp(turn), Eigen::Vector3d::Zero()};
  const lie::SE3d carry =
      measurements.T_body_left * T_left_stated.inverse() * measurements.T_body_left.inverse();
  for (RelativeMotion& motion : measurements.odometry) {
    motion.T_body0_body1 = carry * motion.T_body0_body1 * carry.inverse();
  }
  measurements.imu_noise.gyro_bias_sigma = 5e-4;
  return measurements;
}

TEST(EstimateBatch, ATrustedImuTellsHowTheCameraIsTurned) {
  const SineWorld world;
  const Eigen::Vector3d turn(0.004, -0.006, 0.005);
  const auto estimate = estimate_batch(through_turned_camera(world, turn), kRectified, {});
  ASSERT_TRUE(estimate.camera_rotation && estimate.camera_rotation->sigma);
  EXPECT_LT((estimate.camera_rotation->value - turn).norm(), 3e-4)
      << estimate.camera_rotation->value.transpose();
  EXPECT_LT(estimate.camera_rotation->sigma->maxCoeff(), 1e-3);
  EXPECT_LT(world.largest_error(trajectory_of(estimate.graph.states)), 5e-3);
  const auto straight = estimate_batch(through_turned_camera(world, {0, 0, 0}), kRectified, {});
  EXPECT_LT(straight.camera_rotation->value.norm(), 1e-4) << "made up";
}

TEST(EstimateBatch, TheAxesOfAPhonesGyroDoNotTurnTheCamera) {
  Measurements measurements = through_turned_camera(SineWorld(), {0.004, -0.006, 0.005});
  measurements.imu_noise.gyro_bias_sigma = 0.1;
  const auto estimate = estimate_batch(measurements, {}, {});
  EXPECT_FALSE(estimate.camera_rotation);
  EXPECT_EQ(estimate.graph.globals.camera_rotation, Eigen::Vector3d::Zero());
}

/// Read by a gyro whose scale and axes are off.
Measurements with_coarse_gyro(const SineWorld& world, const Eigen::Matrix3d& shape) {
  Measurements measurements = world.measure();
  for (ImuSample& sample : measurements.imu) {
    sample.angular_velocity += shape * sample.angular_velocity;
  }
  return measurements;
}

TEST(EstimateBatch, VisionTellsTheScaleAndTheAxesOfACoarseGyro) {
  const SineWorld world;
  Eigen::Matrix3d shape;
  shape << 0.006, 0.003, -0.004, -0.002, -0.008, 0.003, 0.004, 0.002, 0.005;
  Measurements measurements = with_coarse_gyro(world, shape);
  const auto believed = estimate_batch(measurements, {}, {});
  EXPECT_FALSE(believed.gyro_shape);
  EXPECT_EQ(believed.graph.globals.gyro_shape, Eigen::Matrix3d::Zero());
  measurements.gyro_shape_sigma = 0.01;
  SlamOptions options;
  options.pgo.estimate_focal_error = false;  // would take up what all axes have in common
  const auto estimate = estimate_batch(measurements, kRectified, options);
  ASSERT_TRUE(estimate.gyro_shape && estimate.gyro_shape->sigma);
  EXPECT_LT((estimate.gyro_shape->value - shape).cwiseAbs().maxCoeff(), 1e-3)
      << estimate.gyro_shape->value << "\n"
      << *estimate.gyro_shape->sigma;
  EXPECT_LT(estimate.gyro_shape->sigma->maxCoeff(), 5e-3);
  EXPECT_LT(estimate.report.cost, 0.5 * believed.report.cost);
}

/// As if the images within [from_s, to_s) were shown backwards.
void reverse_odometry(Measurements& measurements, double from_s, double to_s) {
  for (RelativeMotion& motion : measurements.odometry) {
    if (motion.time0_ns < imu::testing::stamp(from_s) ||
        motion.time1_ns > imu::testing::stamp(to_s)) {
      continue;
    }
    motion.T_body0_body1 = motion.T_body0_body1.inverse();
  }
}

TEST(EstimateBatch, WhereVisionContradictsTheGyroTheImuBridges) {
  const SineWorld world;
  Measurements measurements = world.measure();
  reverse_odometry(measurements, 2.5, 3.5);
  const auto estimate = estimate_batch(measurements, {}, {});
  EXPECT_GT(std::count(estimate.conflict.begin(), estimate.conflict.end(), true), 15);
  EXPECT_LT(estimate.report.cost / estimate.report.residuals, 0.5);
  EXPECT_LT(world.largest_error(trajectory_of(estimate.graph.states)), 0.02);
}

TEST(EstimateBatch, WhereTheyContradictEachOtherThroughoutNeitherIsLeftOut) {
  const SineWorld world;
  Measurements measurements = world.measure();
  reverse_odometry(measurements, 0.0, 6.0);
  const auto estimate = estimate_batch(measurements, {}, {});
  EXPECT_EQ(estimate.graph.visual_edges.size(), measurements.odometry.size());
}

TEST(EstimateBatch, ThePublishedPresetSolvesWindowByWindow) {
  const SineWorld world;
  SlamOptions options;
  options.system.preset = "paper";
  const auto estimate = estimate_batch(world.measure(), {}, options);
  EXPECT_EQ(estimate.graph.states.size(), 121U);
  EXPECT_TRUE(estimate.graph.visual_edges.empty());
  EXPECT_LT(world.largest_error(trajectory_of(estimate.graph.states)), 0.05);
}

}  // namespace
}  // namespace imslam::system
