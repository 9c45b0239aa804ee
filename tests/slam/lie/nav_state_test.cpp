#include "slam/lie/nav_state.hpp"

#include <gtest/gtest.h>

#include "tests/support/numeric_jacobian.hpp"

namespace imslam::lie {
namespace {

using testing::expect_near;
using Tangent = NavState::Tangent;

Tangent tangent(double scale) {
  return scale * (Tangent() << 0.3, -1.2, 0.7, 0.4, -0.2, 0.9, 2.0, -3.0, 0.5).finished();
}

const NavState kState = NavState{}.plus(tangent(1.3));

TEST(NavState, MinusInvertsPlus) {
  for (const double scale : {0.0, 1e-7, 0.5, 1.0, 2.5}) {
    expect_near(kState.plus(tangent(scale)).minus(kState), tangent(scale), 1e-9);
  }
}

TEST(NavState, PlusInvertsMinus) {
  const NavState other = NavState{}.plus(tangent(-0.7));
  const NavState back = kState.plus(other.minus(kState));
  expect_near(back.T_world_body.matrix(), other.T_world_body.matrix(), 1e-12);
  expect_near(back.v_world, other.v_world, 1e-12);
}

TEST(NavState, AStepMovesTheBodyInItsOwnFrameAndTheVelocityInTheWorld) {
  Tangent step = Tangent::Zero();
  step.head<3>() << 1.0, 0.0, 0.0;
  step.tail<3>() << 0.0, 1.0, 0.0;
  const NavState moved = kState.plus(step);
  const Eigen::Vector3d forward = kState.T_world_body.rotation() * Eigen::Vector3d::UnitX();
  expect_near(moved.T_world_body.translation(), kState.T_world_body.translation() + forward, 1e-12);
  expect_near(moved.v_world, kState.v_world + Eigen::Vector3d::UnitY(), 1e-12);
}

}  // namespace
}  // namespace imslam::lie
