#include "slam/sensors/calibration.hpp"

#include <gtest/gtest.h>

#include "tests/support/numeric_jacobian.hpp"

namespace imslam {
namespace {

using testing::expect_near;

StereoCamera camera() {
  StereoCamera camera;
  camera.width = 752;
  camera.height = 480;
  camera.fx = 435.2;
  camera.fy = 437.9;
  camera.cx = 367.4;
  camera.cy = 252.2;
  camera.baseline_m = 0.11;
  return camera;
}

TEST(StereoCamera, BackProjectInvertsProject) {
  for (const Eigen::Vector3d& p : {Eigen::Vector3d(0.0, 0.0, 1.0), Eigen::Vector3d(-2.0, 1.0, 0.3),
                                   Eigen::Vector3d(30, -7, 200)}) {
    expect_near(camera().back_project(camera().project(p)), p, 1e-12);
  }
}

TEST(StereoCamera, TheAxisPointsAtThePrincipalPoint) {
  expect_near(camera().project({0.0, 0.0, 2.0}), Eigen::Vector3d(367.4, 252.2, 435.2 * 0.11 / 2.0),
              1e-12);
}

TEST(StereoCamera, RightAndDownArePositive) {
  const Eigen::Vector3d uvd = camera().project({0.5, 0.25, 2.0});
  EXPECT_DOUBLE_EQ(uvd.x(), 367.4 + 435.2 * 0.25);
  EXPECT_DOUBLE_EQ(uvd.y(), 252.2 + 437.9 * 0.125);
}

// What the right camera, one baseline further right, sees in the same row.
TEST(StereoCamera, DisparityIsTheShiftBetweenTheCameras) {
  const Eigen::Vector3d p(0.5, 0.25, 2.0);
  const Eigen::Vector3d left = camera().project(p);
  const Eigen::Vector3d right = camera().project(p - Eigen::Vector3d(0.11, 0.0, 0.0));
  EXPECT_NEAR(left.x() - right.x(), left.z(), 1e-12);
  EXPECT_NEAR(left.y(), right.y(), 1e-12);
}

}  // namespace
}  // namespace imslam
