#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <opencv2/core.hpp>
#include <opencv2/imgproc.hpp>

#include "datasets/simulation/simulator.hpp"
#include "slam/base/parallel.hpp"

namespace imslam::simulation {
namespace {

/// Sharp, noise-free and small, so that what is left is the renderer.
SimulationOptions clean_options(const std::string& scene) {
  SimulationOptions options;
  options.scene = scene;
  options.textures = "procedural";
  options.duration_s = 6.0;
  options.rest_s = 0.0;
  options.camera.width = 376;
  options.image.exposure_ms = 0.0;
  options.image.noise_scale = 0.0;
  options.image.vignetting = 0.0;
  options.image.right_gain_percent = 0.0;
  options.image.auto_exposure = false;
  options.dynamic_objects = false;
  return options;
}

double grey_at(const GrayImage& image, const Eigen::Vector2d& pixel) {
  const int x = static_cast<int>(std::floor(pixel.x()));
  const int y = static_cast<int>(std::floor(pixel.y()));
  const double fx = pixel.x() - x;
  const double fy = pixel.y() - y;
  return (1 - fy) * ((1 - fx) * image.at(y, x) + fx * image.at(y, x + 1)) +
         fy * ((1 - fx) * image.at(y + 1, x) + fx * image.at(y + 1, x + 1));
}

bool inside(const Lens& lens, const Eigen::Vector2d& pixel) {
  return pixel.x() >= 0 && pixel.y() >= 0 && pixel.x() < lens.width() - 1 &&
         pixel.y() < lens.height() - 1;
}

Eigen::Vector3d point_at(const SimulatedFrame& frame, const Lens& lens, int row, int column) {
  const Eigen::Vector3d direction = lens.direction({column, row});
  const std::size_t at = static_cast<std::size_t>(row * frame.width + column);
  return direction * (static_cast<double>(frame.depth[at]) / direction.z());
}

/// Median and 90th percentile of absolute values.
struct Spread {
  double median = 0.0;
  double ninety = 0.0;
};

Spread spread(std::vector<double> values) {
  std::sort(values.begin(), values.end());
  if (values.empty()) return {1e9, 1e9};
  return {values[values.size() / 2], values[values.size() * 9 / 10]};
}

/// Left pixels with depth, carried into the right image, must look the same there.
Spread stereo_error(Simulator& simulator, double time_s, double shift_px = 0.0) {
  FrameRequest request;
  request.depth = true;
  const SimulatedFrame frame = simulator.render(time_s, request);
  const StereoRig& rig = simulator.rig();
  const lie::SE3d T_right_left = rig.T_body_right.inverse() * rig.T_body_left;
  std::vector<double> errors;
  for (int row = 2; row < frame.height - 2; row += 2) {
    for (int column = 2; column < frame.width - 2; column += 2) {
      if (frame.depth[static_cast<std::size_t>(row * frame.width + column)] <= 0.0F) continue;
      const auto pixel = rig.right.project(T_right_left * point_at(frame, rig.left, row, column));
      if (!pixel) continue;
      const Eigen::Vector2d moved = *pixel + Eigen::Vector2d(shift_px, 0.0);
      if (!inside(rig.right, moved)) continue;
      errors.push_back(std::abs(grey_at(frame.right, moved) - frame.left.at(row, column)));
    }
  }
  EXPECT_GT(errors.size(), 2000U);
  return spread(errors);
}

TEST(Render, DepthCarriesTheLeftImageOntoTheRight) {
  for (const char* scene : {"room", "corridor", "street"}) {
    Simulator simulator(clean_options(scene));
    const Spread exact = stereo_error(simulator, 3.0);
    EXPECT_LT(exact.median, 2.5) << scene;
    EXPECT_LT(exact.ninety, 14.0) << scene;
    // Half a pixel off must look clearly worse, on either side: the test can fail.
    EXPECT_GT(stereo_error(simulator, 3.0, 0.5).median, 1.25 * exact.median) << scene;
    EXPECT_GT(stereo_error(simulator, 3.0, -0.5).median, 1.25 * exact.median) << scene;
  }
}

TEST(Render, FisheyeImagesAgreeToo) {
  SimulationOptions options = clean_options("room");
  options.camera.preset = "tumvi";
  options.camera.width = 256;
  Simulator simulator(options);
  EXPECT_LT(stereo_error(simulator, 3.0).median, 4.0);
}

TEST(Render, FlowIsDepthMovedByTheTrueMotion) {
  Simulator simulator(clean_options("room"));
  FrameRequest request;
  request.depth = true;
  request.flow_to_s = 3.05;
  const SimulatedFrame frame = simulator.render(3.0, request);
  const StereoRig& rig = simulator.rig();
  const auto left_pose = [&](double t) {
    return simulator.motion().at(t).T_world_body * rig.T_body_left;
  };
  const lie::SE3d T_left1_left0 = left_pose(3.05).inverse() * left_pose(3.0);
  double largest = 0.0;
  for (int row = 0; row < frame.height; row += 5) {
    for (int column = 0; column < frame.width; column += 5) {
      const std::size_t at = static_cast<std::size_t>(row * frame.width + column);
      if (frame.flow_valid[at] == 0) continue;
      const auto pixel = rig.left.project(T_left1_left0 * point_at(frame, rig.left, row, column));
      ASSERT_TRUE(pixel);
      EXPECT_NEAR(pixel->x() - column, frame.flow[2 * at], 2e-3);
      EXPECT_NEAR(pixel->y() - row, frame.flow[2 * at + 1], 2e-3);
      largest = std::max(largest, static_cast<double>(std::abs(frame.flow[2 * at])));
    }
  }
  EXPECT_GT(largest, 0.5);
}

TEST(Render, FlowCarriesAnImageOntoTheNext) {
  Simulator simulator(clean_options("room"));
  FrameRequest request;
  request.flow_to_s = 3.1;
  const SimulatedFrame first = simulator.render(3.0, request);
  const SimulatedFrame second = simulator.render(3.1);
  std::vector<double> errors;
  std::vector<double> without;
  for (int row = 2; row < first.height - 2; row += 2) {
    for (int column = 2; column < first.width - 2; column += 2) {
      const std::size_t at = static_cast<std::size_t>(row * first.width + column);
      const Eigen::Vector2d pixel(column + static_cast<double>(first.flow[2 * at]),
                                  row + static_cast<double>(first.flow[2 * at + 1]));
      if (first.flow_valid[at] == 0 || !inside(simulator.rig().left, pixel)) continue;
      const double grey = first.left.at(row, column);
      errors.push_back(std::abs(grey_at(second.left, pixel) - grey));
      without.push_back(std::abs(second.left.at(row, column) - grey));
    }
  }
  EXPECT_LT(spread(errors).median, 2.5);
  EXPECT_GT(spread(without).median, 2.0 * spread(errors).median);
}

TEST(Render, DrivingCarsHaveTheirOwnFlow) {
  SimulationOptions options = clean_options("street");
  options.motion = "static";
  options.dynamic_objects = true;
  Simulator simulator(options);
  std::size_t moving = 0;
  std::size_t all = 0;
  for (double t = 0.5; t < 6.0; t += 0.5) {
    FrameRequest request;
    request.flow_to_s = t + 0.05;
    const SimulatedFrame frame = simulator.render(t, request);
    for (std::size_t i = 0; i < frame.flow.size(); i += 2) {
      moving += std::hypot(frame.flow[i], frame.flow[i + 1]) > 0.2F ? 1 : 0;
      ++all;
    }
  }
  EXPECT_GT(moving, all / 5000);  // the oncoming ones
  EXPECT_LT(moving, all / 4);     // everything else stands
}

TEST(Render, AStaticCameraInAStaticWorldHasNoFlow) {
  SimulationOptions options = clean_options("corridor");
  options.motion = "static";
  Simulator simulator(options);
  FrameRequest request;
  request.flow_to_s = 2.05;
  const SimulatedFrame frame = simulator.render(2.0, request);
  for (const float displacement : frame.flow) ASSERT_LT(std::abs(displacement), 1e-4F);
  EXPECT_EQ(frame.left.pixels, simulator.render(4.0).left.pixels);
}

TEST(Render, TheRightImageShowsNearThingsFurtherLeft) {
  SimulationOptions options = clean_options("corridor");
  options.camera.misalignment_deg = 0.0;
  options.camera.mounting_deg = 0.0;
  Simulator simulator(options);
  const StereoRig& rig = simulator.rig();
  const lie::SE3d T_right_left = rig.T_body_right.inverse() * rig.T_body_left;
  EXPECT_NEAR(T_right_left.translation().x(), -0.11, 1e-9);
  const auto left = rig.left.project({0.1, 0.0, 2.0});
  const auto right = rig.right.project(T_right_left * Eigen::Vector3d(0.1, 0.0, 2.0));
  EXPECT_LT(right->x(), left->x() - 5.0);
}

TEST(Render, SameBytesForOneAndTwoThreadsAndForTwoSimulatorsInEveryScene) {
  const int threads = thread_count();
  for (const char* scene : {"room", "corridor", "forest", "street"}) {
    SimulationOptions options = clean_options(scene);
    options.camera.width = 150;  // tiles stick out at the right
    options.dynamic_objects = true;
    options.image.exposure_ms = 8.0;
    options.image.noise_scale = 1.0;
    FrameRequest request;
    request.depth = true;
    request.flow_to_s = 4.05;
    set_thread_count(1);
    const SimulatedFrame first = Simulator(options).render(4.0, request);
    set_thread_count(2);
    Simulator two(options);
    two.render(1.0);  // another instant in between must not matter
    const SimulatedFrame second = two.render(4.0, request);
    set_thread_count(threads);
    EXPECT_EQ(first.left.pixels, second.left.pixels) << scene;
    EXPECT_EQ(first.right.pixels, second.right.pixels) << scene;
    EXPECT_EQ(first.depth, second.depth) << scene;
    EXPECT_EQ(first.flow, second.flow) << scene;
  }
}

TEST(Render, ASimulatorLeavesTheNumberOfThreadsAlone) {
  const int threads = thread_count();
  set_thread_count(2);
  Simulator simulator(clean_options("room"));
  EXPECT_EQ(thread_count(), 2);  // the ray tracer's library likes to hold the process to its own
  set_thread_count(threads);
}

TEST(Render, AnotherSeedIsAnotherWorld) {
  SimulationOptions options = clean_options("room");
  const GrayImage first = Simulator(options).render(2.0).left;
  options.seed = 2;
  EXPECT_NE(first.pixels, Simulator(options).render(2.0).left.pixels);
}

double sharpness(const GrayImage& image) {
  const cv::Mat grey(image.height, image.width, CV_8U,
                     const_cast<std::uint8_t*>(image.pixels.data()));
  cv::Mat edges;
  cv::Laplacian(grey, edges, CV_32F);
  return cv::norm(edges, cv::NORM_L1) / static_cast<double>(edges.total());
}

TEST(Render, ExposureBlursWhatMovesAndOnlyThat) {
  SimulationOptions options = clean_options("room");
  const double sharp = sharpness(Simulator(options).render(3.0).left);
  options.image.exposure_ms = 25.0;
  EXPECT_LT(sharpness(Simulator(options).render(3.0).left), 0.8 * sharp);
  options.motion = "static";
  const GrayImage still = Simulator(options).render(3.0).left;
  options.image.exposure_ms = 0.0;
  EXPECT_EQ(still.pixels, Simulator(options).render(3.0).left.pixels);
}

// Nearest thing on the whole way, in every family and several layouts: no flying through walls.
TEST(Render, TheCameraKeepsClearOfEverything) {
  for (const char* scene : {"room", "corridor", "forest", "street"}) {
    for (const int seed : {1, 2}) {
      SimulationOptions options = clean_options(scene);
      options.camera.width = 47;
      options.antialias = false;
      options.seed = seed;
      options.duration_s = 60.0;
      Simulator simulator(options);
      FrameRequest request;
      request.depth = true;
      for (double t = 0.0; t <= 60.0; t += 1.0) {
        const SimulatedFrame frame = simulator.render(t, request);
        for (const float depth : frame.depth) {
          ASSERT_TRUE(depth == 0.0F || depth > 0.2F) << scene << " " << seed << " " << t;
        }
      }
    }
  }
}

TEST(Render, ImagesAreNeitherBlackNorWhiteAndFullOfCorners) {
  for (const char* scene : {"room", "corridor", "forest", "street"}) {
    SimulationOptions options = clean_options(scene);
    options.image.auto_exposure = true;
    options.image.noise_scale = 1.0;
    Simulator simulator(options);
    for (const double t : {0.0, 3.0, 6.0}) {
      const GrayImage image = simulator.render(t).left;
      const cv::Mat grey(image.height, image.width, CV_8U,
                         const_cast<std::uint8_t*>(image.pixels.data()));
      EXPECT_GT(cv::mean(grey)[0], 50.0) << scene << t;
      EXPECT_LT(cv::mean(grey)[0], 190.0) << scene << t;
      std::vector<cv::Point2f> corners;
      cv::goodFeaturesToTrack(grey, corners, 400, 0.01, 8);
      EXPECT_GT(corners.size(), 150U) << scene << t;
    }
  }
}

}  // namespace
}  // namespace imslam::simulation
