#include "datasets/simulation/motion_spline.hpp"

#include <gtest/gtest.h>

#include "slam/base/random.hpp"
#include "tests/support/numeric_jacobian.hpp"

namespace imslam::simulation {
namespace {

using testing::expect_near;

constexpr double kKnot = 0.1;

MotionSpline restless_spline() {
  Random random(5);
  std::vector<lie::SE3d> controls;
  lie::SO3d R;
  for (int k = 0; k < 40; ++k) {
    R = R * lie::SO3d::exp(0.2 * random.normal3());
    controls.emplace_back(R, random.normal3());
  }
  return MotionSpline(kKnot, controls);
}

TEST(MotionSpline, VelocityAndAccelerationMatchCentralDifferences) {
  const MotionSpline spline = restless_spline();
  const double h = 1e-5;
  for (double t = 0.013; t < spline.duration_s() - 0.1; t += 0.0317) {
    const MotionState before = spline.at(t - h);
    const MotionState after = spline.at(t + h);
    const MotionState now = spline.at(t);
    expect_near(now.v_world,
                (after.T_world_body.translation() - before.T_world_body.translation()) / (2 * h),
                1e-6);
    expect_near(now.a_world, (after.v_world - before.v_world) / (2 * h), 1e-6);
  }
}

TEST(MotionSpline, AngularRateAndAccelerationMatchCentralDifferences) {
  const MotionSpline spline = restless_spline();
  const double h = 1e-5;
  for (double t = 0.013; t < spline.duration_s() - 0.1; t += 0.0317) {
    const MotionState before = spline.at(t - h);
    const MotionState after = spline.at(t + h);
    const MotionState now = spline.at(t);
    const auto turn = before.T_world_body.rotation().inverse() * after.T_world_body.rotation();
    expect_near(now.omega_body, turn.log() / (2 * h), 1e-6);
    expect_near(now.alpha_body, (after.omega_body - before.omega_body) / (2 * h), 1e-6);
  }
}

TEST(MotionSpline, AccelerationAndAngularAccelerationAreContinuousAtTheKnots) {
  const MotionSpline spline = restless_spline();
  for (int k = 1; k < 30; ++k) {
    const MotionState left = spline.at(k * kKnot - 1e-10);
    const MotionState right = spline.at(k * kKnot + 1e-10);
    expect_near(left.a_world, right.a_world, 1e-5);
    expect_near(left.alpha_body, right.alpha_body, 1e-5);
  }
}

TEST(MotionSpline, EqualControlPosesAreExactRest) {
  const lie::SE3d pose(lie::SO3d::exp({0.3, -0.2, 1.0}), {1.0, 2.0, 3.0});
  const MotionSpline spline(kKnot, std::vector<lie::SE3d>(12, pose));
  const MotionState state = spline.at(0.37);
  EXPECT_LT((state.T_world_body.inverse() * pose).log().norm(), 1e-14);
  EXPECT_LT(state.v_world.norm(), 1e-12);
  EXPECT_LT(state.a_world.norm(), 1e-11);
  EXPECT_EQ(state.omega_body.norm(), 0.0);
}

TEST(MotionSpline, ControlPointsOnAParabolaGiveConstantAcceleration) {
  std::vector<lie::SE3d> controls;
  for (std::size_t k = 0; k < 20; ++k) {
    const double t = MotionSpline::control_time(kKnot, k);
    controls.emplace_back(lie::SO3d(), Eigen::Vector3d(t, 0.0, -4.905 * t * t));
  }
  const MotionSpline spline(kKnot, controls);
  for (const double t : {0.0, 0.51, 1.2}) {
    const MotionState state = spline.at(t);
    expect_near(state.a_world, Eigen::Vector3d(0, 0, -9.81), 1e-10);
    expect_near(state.v_world, Eigen::Vector3d(1.0, 0, -9.81 * t), 1e-10);
    EXPECT_NEAR(state.T_world_body.translation().x(), t, 1e-12);
  }
}

TEST(MotionSpline, CoversTheDurationThatWasAskedFor) {
  for (const double duration : {0.1, 1.0, 2.05, 60.0}) {
    const std::size_t count = MotionSpline::control_count(kKnot, duration);
    const MotionSpline spline(kKnot, std::vector<lie::SE3d>(count));
    EXPECT_GE(spline.duration_s(), duration - 1e-9);
    EXPECT_LT(spline.duration_s(), duration + 2 * kKnot);
  }
}

}  // namespace
}  // namespace imslam::simulation
