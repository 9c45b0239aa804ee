#include "datasets/rectify.hpp"

#include <gtest/gtest.h>

#include <opencv2/calib3d.hpp>
#include <opencv2/imgproc.hpp>

#include "tests/datasets/expect_error.hpp"

namespace imslam::datasets {
namespace {

using imslam::testing::expect_input_error;

RawCamera camera_of(LensModel lens) {
  RawCamera camera;
  camera.width = 752;
  camera.height = 480;
  camera.fx = 458.7;
  camera.fy = 457.3;
  camera.cx = 367.2;
  camera.cy = 248.4;
  camera.lens = lens;
  camera.distortion = lens == LensModel::kEquidistant
                          ? std::vector<double>{0.0034, 0.0007, -0.002, 0.0002}
                          : std::vector<double>{-0.283, 0.074, 0.0002, 1.8e-5};
  camera.where = "cam.yaml:3";
  const Eigen::Matrix<double, 6, 1> tau =
      (Eigen::Matrix<double, 6, 1>() << 0.1, -0.2, 0.05, 0.3, -0.4, 0.5).finished();
  camera.T_body_camera = lie::SE3d::exp(tau);
  return camera;
}

/// To the right of `left`, looking slightly elsewhere.
RawCamera right_of(const RawCamera& left) {
  RawCamera right = left;
  right.cx += 9.0;
  right.fx -= 1.0;
  right.T_body_camera =
      left.T_body_camera * lie::SE3d(lie::SO3d::exp(Eigen::Vector3d(0.01, -0.02, 0.014)),
                                     Eigen::Vector3d(0.11, 0.002, -0.003));
  return right;
}

cv::Point2d raw_projection(const RawCamera& camera, const Eigen::Vector3d& p_body) {
  const Eigen::Vector3d p = camera.T_body_camera.inverse() * p_body;
  const cv::Matx33d K(camera.fx, 0, camera.cx, 0, camera.fy, camera.cy, 0, 0, 1);
  const std::vector<cv::Point3d> points = {{p.x(), p.y(), p.z()}};
  std::vector<cv::Point2d> pixels;
  const cv::Vec3d zero(0, 0, 0);
  if (camera.lens == LensModel::kEquidistant) {
    cv::fisheye::projectPoints(points, pixels, zero, zero, K, camera.distortion);
  } else {
    cv::projectPoints(points, zero, zero, K, camera.distortion, pixels);
  }
  return pixels[0];
}

/// A soft bright spot, so that its centre of mass is known to a fraction of a pixel.
GrayImage spot_at(const RawCamera& camera, const cv::Point2d& centre) {
  GrayImage image{camera.width, camera.height, {}};
  for (int v = 0; v < image.height; ++v) {
    for (int u = 0; u < image.width; ++u) {
      const double r_sq = std::pow(u - centre.x, 2) + std::pow(v - centre.y, 2);
      image.pixels.push_back(static_cast<std::uint8_t>(std::lround(250.0 * std::exp(-r_sq / 18))));
    }
  }
  return image;
}

Eigen::Vector2d centre_of_mass(const GrayImage& image) {
  Eigen::Vector3d sum = Eigen::Vector3d::Zero();
  for (int v = 0; v < image.height; ++v) {
    for (int u = 0; u < image.width; ++u) sum += image.at(v, u) * Eigen::Vector3d(u, v, 1);
  }
  return sum.head<2>() / sum.z();
}

class StereoRectifierOf : public ::testing::TestWithParam<LensModel> {};

TEST_P(StereoRectifierOf, PutsAPointWhereTheRectifiedCameraProjectsIt) {
  const RawCamera left = camera_of(GetParam());
  const RawCamera right = right_of(left);
  const StereoRectifier rectifier(left, right);
  const StereoCamera& camera = rectifier.camera();
  EXPECT_NEAR(camera.baseline_m, Eigen::Vector3d(0.11, 0.002, -0.003).norm(), 1e-12);
  for (const Eigen::Vector3d& p_raw :
       {Eigen::Vector3d(0.0, 0.0, 2.0), Eigen::Vector3d(0.7, -0.3, 2.0),
        Eigen::Vector3d(-0.9, 0.5, 2.5), Eigen::Vector3d(1.5, 1.0, 6.0)}) {
    const Eigen::Vector3d p_body = left.T_body_camera * p_raw;
    const Eigen::Vector3d uvd = camera.project(camera.T_body_left.inverse() * p_body);
    const auto seen_left =
        centre_of_mass(rectifier.left(spot_at(left, raw_projection(left, p_body))));
    const auto seen_right =
        centre_of_mass(rectifier.right(spot_at(right, raw_projection(right, p_body))));
    EXPECT_NEAR(seen_left.x(), uvd.x(), 0.15);
    EXPECT_NEAR(seen_left.y(), uvd.y(), 0.15);
    EXPECT_NEAR(seen_left.x() - seen_right.x(), uvd.z(), 0.15);
    EXPECT_NEAR(seen_left.y(), seen_right.y(), 0.1);
  }
}

INSTANTIATE_TEST_SUITE_P(Lenses,
                         StereoRectifierOf,
                         ::testing::Values(LensModel::kRadialTangential, LensModel::kEquidistant));

TEST(StereoRectifier, EveryRectifiedPixelOfARadialLensHasAnOriginal) {
  const RawCamera left = camera_of(LensModel::kRadialTangential);
  const StereoRectifier rectifier(left, right_of(left));
  const GrayImage white{752, 480, std::vector<std::uint8_t>(752 * 480, 200)};
  const GrayImage rectified = rectifier.left(white);
  EXPECT_EQ(std::count(rectified.pixels.begin(), rectified.pixels.end(), 0), 0);
}

TEST(StereoRectifier, LeavesRectifiedPairsAsTheyAre) {
  StereoCamera camera;
  camera.width = 2;
  camera.height = 1;
  const StereoRectifier rectifier(camera);
  const GrayImage image{2, 1, {3, 4}};
  EXPECT_EQ(rectifier.left(image).pixels, image.pixels);
  EXPECT_TRUE(rectifier.right(GrayImage()).empty());
}

TEST(StereoRectifier, RefusesImpossiblePairs) {
  const RawCamera left = camera_of(LensModel::kRadialTangential);
  const auto refuse = [&](const RawCamera& right, const std::string& word) {
    expect_input_error([&] { StereoRectifier(left, right); }, ExitCode::kCalibration,
                       {"cam.yaml:3", word});
  };
  RawCamera right = right_of(left);
  right.width = 640;
  refuse(right, "640x480");
  right = right_of(left);
  right.lens = LensModel::kEquidistant;
  refuse(right, "equidistant");
  right = right_of(left);
  right.T_body_camera = left.T_body_camera;
  refuse(right, "0 m apart");
  const auto place = [&](const Eigen::Vector3d& p_left, double angle = 0.0) {
    right.T_body_camera =
        left.T_body_camera * lie::SE3d(lie::SO3d::exp(Eigen::Vector3d(0, angle, 0)), p_left);
    return right;
  };
  refuse(place({20.0, 0, 0}), "20 m apart");
  refuse(place({110.0, 0, 0}), "metres");
  refuse(place({-0.11, 0, 0}), "to the left");
  refuse(place({0.0, 0.11, 0}), "side by side");
  refuse(place({0.11, 0, 0}, 2.0), "look 115 degrees apart");
}

}  // namespace
}  // namespace imslam::datasets
