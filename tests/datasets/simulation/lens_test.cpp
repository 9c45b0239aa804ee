#include "datasets/simulation/lens.hpp"

#include <gtest/gtest.h>

#include <opencv2/calib3d.hpp>
#include <vector>

#include "slam/base/random.hpp"

namespace imslam::simulation {
namespace {

const Lens kRadTan(Distortion::kRadTan,
                   752,
                   480,
                   {458.654, 457.296, 367.215, 248.375},
                   {-0.28340811, 0.07395907, 0.00019359, 1.76187114e-05});
const Lens kFish(Distortion::kEquidistant,
                 512,
                 512,
                 {190.98, 190.97, 254.93, 256.90},
                 {0.0034823894, 0.0007150348, -0.0020532361, 0.00020293673});

cv::Matx33d camera_matrix(const Lens& lens) {
  const auto& k = lens.intrinsics();
  return {k[0], 0, k[2], 0, k[1], k[3], 0, 0, 1};
}

std::vector<cv::Point3d> points_in_view() {
  Random random(3);
  std::vector<cv::Point3d> points;
  for (int i = 0; i < 200; ++i) {
    const double x = random.uniform(-0.8, 0.8);
    const double y = random.uniform(-0.5, 0.5);
    const double z = random.uniform(0.5, 20.0);
    points.emplace_back(x * z, y * z, z);
  }
  return points;
}

TEST(Lens, RadTanAgreesWithOpenCvProjectPoints) {
  const auto points = points_in_view();
  std::vector<cv::Point2d> expected;
  cv::projectPoints(points, cv::Vec3d(), cv::Vec3d(), camera_matrix(kRadTan),
                    kRadTan.coefficients(), expected);
  for (std::size_t i = 0; i < points.size(); ++i) {
    const auto pixel = kRadTan.project({points[i].x, points[i].y, points[i].z});
    ASSERT_TRUE(pixel);
    EXPECT_NEAR(pixel->x(), expected[i].x, 1e-9);
    EXPECT_NEAR(pixel->y(), expected[i].y, 1e-9);
  }
}

TEST(Lens, EquidistantAgreesWithOpenCvFisheye) {
  const auto points = points_in_view();
  std::vector<cv::Point2d> expected;
  cv::fisheye::projectPoints(points, expected, cv::Vec3d(), cv::Vec3d(), camera_matrix(kFish),
                             cv::Mat(kFish.coefficients()));
  for (std::size_t i = 0; i < points.size(); ++i) {
    const auto pixel = kFish.project({points[i].x, points[i].y, points[i].z});
    ASSERT_TRUE(pixel);
    EXPECT_NEAR(pixel->x(), expected[i].x, 1e-6);
    EXPECT_NEAR(pixel->y(), expected[i].y, 1e-6);
  }
}

TEST(Lens, ProjectInvertsDirectionOverTheWholeImage) {
  for (const Lens* lens : {&kRadTan, &kFish}) {
    for (int row = -1; row <= lens->height(); row += 13) {
      for (int column = -1; column <= lens->width(); column += 17) {
        const Eigen::Vector2d pixel(column, row);
        const Eigen::Vector3d direction = lens->direction(pixel);
        EXPECT_NEAR(direction.norm(), 1.0, 1e-12);
        const auto back = lens->project(7.5 * direction);
        ASSERT_TRUE(back) << column << " " << row;
        EXPECT_LT((*back - pixel).norm(), 1e-8) << column << " " << row;
      }
    }
  }
}

TEST(Lens, SeesNothingBehindOrBeyondTheFold) {
  EXPECT_FALSE(kRadTan.project({0.1, 0.1, -1.0}));
  EXPECT_FALSE(kFish.project({0.001, 0.0, -1.0}));
  const Lens barrel(Distortion::kRadTan, 100, 100, {50, 50, 50, 50}, {-0.4, 0.0, 0.0, 0.0});
  EXPECT_TRUE(barrel.project({0.9, 0.0, 1.0}));
  EXPECT_FALSE(barrel.project({0.92, 0.0, 1.0}));  // the fold lies at sqrt(1 / 1.2) = 0.9129
}

}  // namespace
}  // namespace imslam::simulation
