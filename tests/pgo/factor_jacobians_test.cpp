#include <gtest/gtest.h>

#include "pgo/imu_factor.hpp"
#include "pgo/marginal_prior_factor.hpp"
#include "pgo/prior_factors.hpp"
#include "pgo/relative_pose_factor.hpp"
#include "pgo/whitening.hpp"
#include "tests/pgo/check_factor.hpp"
#include "tests/pgo/synthetic.hpp"
#include "tests/support/numeric_jacobian.hpp"

namespace imslam::pgo {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;
using Eigen::VectorXd;
using lie::SE3d;
using lie::SO3d;
using testing::expect_jacobians_match;
using testing::expect_near;
using testing::numeric_jacobian;
using testing::pose_block;
using testing::random_matrix;
using testing::random_pose;
using testing::shape_block;
using testing::Vector6;
using testing::Vector9;
using testing::vector_block;

/// Angles of the residual's rotation: none, tiny, ordinary, near a half turn.
const double kAngles[] = {0.0, 1e-9, 1e-4, 0.5, 3.1};

struct VisualCase {
  RelativePoseFactor factor;
  SE3d T0;
  SE3d T1;
  VisualCalibration calibration;
};

VisualCase visual_case(Random& random, double angle, const Vector6& measurement_step) {
  const SE3d T_body_left(SO3d::exp({0.3, -0.2, 1.2}), Vector3d(0.05, 0.02, -0.01));
  const VisualCalibration calibration{0.5, 0.03, {0.04, -0.02, 0.03}};
  const SE3d turn = T_body_left * SE3d(SO3d::exp(calibration.camera_rotation), Vector3d::Zero()) *
                    T_body_left.inverse();
  RelativeMotion motion;
  motion.T_body0_body1 = random_pose(random);
  motion.J_disparity_offset = 0.1 * random_matrix<6, 1>(random);
  motion.disparity_offset = 0.2;
  motion.J_focal_error = random_matrix<6, 1>(random);
  const SE3d T0 = random_pose(random, 3.0);
  Vector6 error;
  error << (angle > 0.0 ? 0.3 : 0.0) * random.normal3(), angle * random.normal3().normalized();
  const SE3d T1 = T0 * turn * motion.T_body0_body1 * turn.inverse() *
                  SE3d::exp(motion.J_disparity_offset *
                                (calibration.disparity_offset - motion.disparity_offset) +
                            motion.J_focal_error * calibration.focal_error) *
                  SE3d::exp(error);
  motion.T_body0_body1 = motion.T_body0_body1 * SE3d::exp(measurement_step);
  const auto W = sqrt_information(testing::random_covariance<6>(random, 0.5));
  return {RelativePoseFactor(motion, *W, T_body_left), T0, T1, calibration};
}

TEST(RelativePoseFactor, JacobiansMatchNumericDerivatives) {
  for (double angle : kAngles) {
    Random random(11);
    const VisualCase c = visual_case(random, angle, Vector6::Zero());
    expect_jacobians_match(c.factor, {pose_block(c.T0),
                                      pose_block(c.T1),
                                      {c.calibration.disparity_offset},
                                      {c.calibration.focal_error},
                                      vector_block(c.calibration.camera_rotation)});
  }
}

TEST(RelativePoseFactor, MeasurementJacobianMatchesCentralDifferences) {
  for (double angle : kAngles) {
    const auto residual = [&](const VectorXd& step) -> VectorXd {
      Random random(12);
      const VisualCase c = visual_case(random, angle, step);
      return c.factor.residual(c.T0, c.T1, c.calibration);
    };
    Random random(12);
    const VisualCase c = visual_case(random, angle, Vector6::Zero());
    expect_near(c.factor.linearize(c.T0, c.T1, c.calibration).J_measurement,
                numeric_jacobian(residual, Vector6::Zero(), 1e-5), 1e-6);
  }
}

TEST(RelativePoseFactor, ResidualIsTheStepFromTheMeasurementToTheStates) {
  Random random(13);
  const SE3d T0 = random_pose(random);
  RelativeMotion motion;
  motion.T_body0_body1 = random_pose(random);
  const Vector6 step = 0.1 * random_matrix<6, 1>(random);
  const RelativePoseFactor factor(motion, 2.0 * Eigen::Matrix<double, 6, 6>::Identity());
  const SE3d T1 = T0 * motion.T_body0_body1 * SE3d::exp(step);
  EXPECT_LT((factor.residual(T0, T1, {}) - 2.0 * step).norm(), 1e-12);
}

struct ImuCase {
  ImuFactor factor;
  ImuFactor::Point at;
};

ImuCase imu_case(Random& random, double angle, const Vector9& measurement_step) {
  ImuMotion motion;
  motion.dt_s = 0.3;
  motion.dR = random_pose(random).rotation();
  motion.dv = random.normal3();
  motion.dp = random.normal3();
  motion.J_dR_bias = 0.3 * random_matrix<3, 6>(random);
  motion.J_dv_bias = 0.3 * random_matrix<3, 6>(random);
  motion.J_dp_bias = 0.1 * random_matrix<3, 6>(random);
  motion.J_time_offset = random_matrix<9, 1>(random);
  motion.bias = {0.1 * random.normal3(), 0.1 * random.normal3()};
  motion.time_offset_s = 0.01;

  ImuFactor::Point at;
  at.T_world_body0 = random_pose(random, 3.0);
  at.bias = 0.2 * random_matrix<6, 1>(random);
  at.time_offset_s = -0.03;
  at.gyro_shape = 0.1 * random_matrix<3, 3>(random);
  Vector6 db = at.bias;
  db.head<3>() -= motion.bias.gyro;
  db.tail<3>() -= motion.bias.accel;
  const Vector3d x = motion.J_dR_bias * db + motion.J_time_offset.head<3>() * -0.04;
  const SO3d read = motion.dR * SO3d::exp(x) * SO3d::exp(angle * random.normal3().normalized());
  const SO3d turn = SO3d::exp((Matrix3d::Identity() + at.gyro_shape).inverse() * read.log());
  at.T_world_body1 = SE3d{at.T_world_body0.rotation() * turn, random.normal3()};
  at.v0_world = random.normal3();
  at.v1_world = random.normal3();
  at.gravity_direction = random.normal3().normalized();

  motion.dR = motion.dR * SO3d::exp(measurement_step.head<3>());
  motion.dv += measurement_step.segment<3>(3);
  motion.dp += measurement_step.tail<3>();
  const auto W = sqrt_information(testing::random_covariance<9>(random, 0.5));
  return {ImuFactor(motion, *W, 9.81), at};
}

TEST(ImuFactor, JacobiansMatchNumericDerivatives) {
  for (double angle : kAngles) {
    Random random(21);
    const ImuCase c = imu_case(random, angle, Vector9::Zero());
    expect_jacobians_match(c.factor,
                           {pose_block(c.at.T_world_body0),
                            vector_block(c.at.v0_world),
                            pose_block(c.at.T_world_body1),
                            vector_block(c.at.v1_world),
                            vector_block(c.at.bias),
                            vector_block(c.at.gravity_direction),
                            {c.at.time_offset_s},
                            shape_block(c.at.gyro_shape)},
                           5);
  }
}

TEST(ImuFactor, MeasurementJacobianMatchesCentralDifferences) {
  for (double angle : kAngles) {
    const auto residual = [&](const VectorXd& step) -> VectorXd {
      Random random(22);
      const ImuCase c = imu_case(random, angle, step);
      return c.factor.residual(c.at);
    };
    Random random(22);
    const ImuCase c = imu_case(random, angle, Vector9::Zero());
    const ImuFactor::Linearization linear = c.factor.linearize(c.at);
    expect_near(linear.J_measurement, numeric_jacobian(residual, Vector9::Zero(), 1e-5), 1e-6);
    expect_near(linear.residual, c.factor.residual(c.at), 1e-12);
  }
}

TEST(ImuFactor, VanishesWhereTheStatesObeyTheMotion) {
  const auto states = testing::wavy_states(2, 0.5);
  const ImuFactor factor(testing::exact_imu_motion(states[0], states[1]),
                         Eigen::Matrix<double, 9, 9>::Identity(), 9.81);
  ImuFactor::Point at{states[0].nav.T_world_body,
                      states[0].nav.v_world,
                      states[1].nav.T_world_body,
                      states[1].nav.v_world,
                      Vector6::Zero(),
                      -Vector3d::UnitZ(),
                      0.0};
  EXPECT_LT(factor.residual(at).norm(), 1e-14);
  at.gravity_direction = Vector3d::UnitZ();
  EXPECT_GT(factor.residual(at).norm(), 1.0);
}

/// A body that turns steadily, read by a gyro whose axes are off by the shape.
TEST(ImuFactor, VanishesWhereACoarseGyroTurnsSteadily) {
  Random random(23);
  for (double angle : {0.05, 0.3, 1.5}) {
    const Vector3d turn = angle * random.normal3().normalized();
    ImuMotion motion;
    motion.dt_s = 0.1;
    ImuFactor::Point at;
    at.gyro_shape = 1e-3 * random_matrix<3, 3>(random);
    motion.dR = SO3d::exp(turn + at.gyro_shape * turn);
    at.T_world_body1 = SE3d(SO3d::exp(turn), Vector3d::Zero());
    const ImuFactor factor(motion, Eigen::Matrix<double, 9, 9>::Identity(), 9.81);
    const double right = factor.residual(at).head<3>().norm();
    at.gyro_shape.setZero();
    const double ignored = factor.residual(at).head<3>().norm();
    EXPECT_GT(ignored, 2e-4 * angle);
    EXPECT_LT(right, 1e-12);
  }
}

TEST(PriorFactors, JacobiansMatchNumericDerivatives) {
  for (double angle : kAngles) {
    Random random(31);
    const SE3d prior = random_pose(random);
    const SE3d pose{prior.rotation() * SO3d::exp(angle * random.normal3().normalized()),
                    prior.translation() + random.normal3()};
    const auto W = sqrt_information(testing::random_covariance<6>(random, 0.3));
    expect_jacobians_match(PosePriorFactor(prior, *W), {pose_block(pose)});
    expect_jacobians_match(AnchorFactor(prior, 0.5, 0.2), {pose_block(pose)});
    const Vector6 a = random_matrix<6, 1>(random);
    const Vector6 b = random_matrix<6, 1>(random);
    expect_jacobians_match(BiasWalkFactor(0.1, 0.2, 0.05), {vector_block(a), vector_block(b)});
    expect_jacobians_match(VectorPriorFactor<6>(a, b.cwiseAbs()), {vector_block(b)});
    const Vector3d n = random.normal3().normalized();
    expect_jacobians_match(VectorPriorFactor<3>(n, Vector3d::Constant(0.1)),
                           {vector_block(random.normal3().normalized())}, 0);
  }
}

TEST(AnchorFactor, LeavesRollAndPitchFree) {
  const SE3d prior = SE3d::exp((Vector6() << 1, 2, 3, 0.1, 0.2, 0.3).finished());
  const AnchorFactor factor(prior, 0.1, 0.1);
  const auto residual = [&](const Vector3d& turn_world) {
    const SE3d pose(SO3d::exp(turn_world) * prior.rotation(), prior.translation());
    const testing::Block block = pose_block(pose);
    const double* parameters[] = {block.data()};
    Eigen::Vector4d r;
    factor.Evaluate(parameters, r.data(), nullptr);
    return r;
  };
  EXPECT_LT(residual({0.2, 0.0, 0.0}).norm(), 1e-12);
  EXPECT_LT(residual({0.0, -0.3, 0.0}).norm(), 1e-12);
  EXPECT_NEAR(residual({0.0, 0.0, 0.2})(3), 2.0, 1e-12);
}

TEST(MarginalPriorFactor, JacobiansMatchNumericDerivatives) {
  for (double angle : kAngles) {
    Random random(41);
    const SE3d X = random_pose(random);
    const SE3d x =
        X * SE3d::exp((Vector6() << 0.2 * random.normal3(), angle * random.normal3().normalized())
                          .finished());
    const Vector3d N = random.normal3().normalized();
    const Vector3d n = (N + 0.1 * random.normal3()).normalized();
    const Vector6 b = random_matrix<6, 1>(random);
    MarginalPrior prior;
    using Kind = BlockId::Kind;
    prior.blocks = {{Kind::kPose, 0},    {Kind::kVelocity, 0},   {Kind::kBias, 0},
                    {Kind::kGravity, 0}, {Kind::kTimeOffset, 0}, {Kind::kGyroShape, 0}};
    const testing::Block X_block = pose_block(X);
    prior.point = {Eigen::Map<const VectorXd>(X_block.data(), 7),
                   random.normal3(),
                   random_matrix<6, 1>(random),
                   N,
                   Eigen::VectorXd::Constant(1, 0.3),
                   random_matrix<9, 1>(random)};
    prior.J = random_matrix<12, 27>(random);
    prior.residual = random_matrix<12, 1>(random);
    expect_jacobians_match(MarginalPriorFactor(prior),
                           {pose_block(x),
                            vector_block(random.normal3()),
                            vector_block(b),
                            vector_block(n),
                            {0.1},
                            vector_block(random_matrix<9, 1>(random))},
                           3);
  }
}

TEST(Whitening, SquaresToTheInverseCovariance) {
  Random random(51);
  const Eigen::Matrix<double, 9, 9> covariance = testing::random_covariance<9>(random, 1e-3);
  const auto W = sqrt_information(covariance);
  ASSERT_TRUE(W);
  expect_near(W->transpose() * *W * covariance, Eigen::MatrixXd::Identity(9, 9), 1e-9);
  EXPECT_EQ(W->triangularView<Eigen::StrictlyUpper>().toDenseMatrix().norm(), 0.0);
}

TEST(Whitening, KeepsASingularCovarianceFinite) {
  // One IMU sample: dp = dv dt / 2 without an error of its own.
  Eigen::Matrix2d covariance;
  covariance << 1e-6, 2.5e-9, 2.5e-9, 6.25e-12;
  const auto W = sqrt_information(covariance);
  ASSERT_TRUE(W);
  EXPECT_TRUE(W->allFinite());
  EXPECT_GT((*W * Eigen::Vector2d(1e-3, -2.5e-6)).norm(), 1e3);
  EXPECT_NEAR((*W * Eigen::Vector2d(1e-3, 2.5e-6)).norm(), 1.0, 1e-3);
  covariance(0, 0) = -1.0;
  EXPECT_FALSE(sqrt_information(covariance));
}

}  // namespace
}  // namespace imslam::pgo
