#include "slam/training/layer.hpp"

#include <gtest/gtest.h>

#include "slam/base/random.hpp"
#include "slam/training/layer_renderer.hpp"

namespace imslam::training {
namespace {

StereoCamera test_camera() {
  StereoCamera camera;
  camera.width = 384;
  camera.height = 256;
  camera.fx = 300.0;
  camera.fy = 310.0;
  camera.cx = 190.0;
  camera.cy = 130.0;
  camera.baseline_m = 0.2;
  return camera;
}

/// A tilted plane through (0.1, -0.2, 2).
Layer tilted_layer() {
  Layer layer;
  layer.origin = {0.1, -0.2, 2.0};
  const Eigen::Vector3d normal = Eigen::Vector3d(0.3, -0.2, 1.0).normalized();
  layer.plane = normal / normal.dot(layer.origin);
  layer.axis_s = 1.5 * Eigen::Vector3d::UnitY().cross(normal).normalized();
  layer.axis_t = 2.0 * normal.cross(layer.axis_s).normalized();
  layer.tile_axis_u = 0.4 * layer.axis_s + 0.2 * layer.axis_t;
  layer.tile_axis_v = 0.3 * layer.axis_t - 0.1 * layer.axis_s;
  layer.tile_offset = {0.3, 0.8};
  return layer;
}

TEST(Layer, CoordinatesInAnyViewAreThoseOfTheSpacePoint) {
  Random random(2);
  const StereoCamera camera = test_camera();
  const Layer layer = tilted_layer();
  const lie::SE3d T(lie::SO3d::exp(Eigen::Vector3d(0.1, -0.2, 0.15)), {0.2, -0.1, 0.3});
  const LayerImage image = project_layer(layer, camera, T);
  for (int i = 0; i < 50; ++i) {
    const double s = random.uniform(-1.0, 1.0);
    const double t = random.uniform(-1.0, 1.0);
    const Eigen::Vector3d p = layer.origin + s * layer.axis_s / layer.axis_s.squaredNorm() +
                              t * layer.axis_t / layer.axis_t.squaredNorm();
    const Eigen::Vector3d p_camera = T * p;
    Eigen::Vector3d pixel = camera.project(p_camera);
    pixel.z() = 1.0;
    const double inverse_depth = image.inverse_depth.dot(pixel);
    EXPECT_NEAR(inverse_depth, 1.0 / p_camera.z(), 1e-12);
    EXPECT_NEAR(image.s.dot(pixel) / inverse_depth, s, 1e-10);
    EXPECT_NEAR(image.t.dot(pixel) / inverse_depth, t, 1e-10);
    EXPECT_NEAR(image.tile_u.dot(pixel) / inverse_depth,
                layer.tile_axis_u.dot(p - layer.origin) + 0.3, 1e-10);
    EXPECT_NEAR(image.tile_v.dot(pixel) / inverse_depth,
                layer.tile_axis_v.dot(p - layer.origin) + 0.8, 1e-10);
  }
}

TEST(Layer, HomographyMapsThePixelsOfItsPoints) {
  const StereoCamera camera = test_camera();
  const Layer layer = tilted_layer();
  const lie::SE3d T(lie::SO3d::exp(Eigen::Vector3d(-0.1, 0.2, 0.05)), {0.1, 0.1, -0.3});
  const Eigen::Matrix3d H = layer_homography(layer, camera, T);
  const Eigen::Vector3d p =
      layer.origin + 0.3 * layer.axis_s.normalized() - 0.2 * layer.axis_t.normalized();
  const Eigen::Vector2d before = camera.project(p).head<2>();
  const Eigen::Vector3d mapped = H * before.homogeneous();
  EXPECT_GT(mapped.z(), 0.0);
  EXPECT_LT((mapped.hnormalized() - camera.project(T * p).head<2>()).norm(), 1e-9);
}

/// One endless layer facing the camera whose texture is a checkerboard of single texels.
std::vector<float> checkerboard_view(double texels_per_pixel) {
  constexpr int kSize = 64;
  std::vector<std::uint8_t> pixels;
  for (int i = 0; i < kSize * kSize; ++i) pixels.push_back((i + i / kSize) % 2 == 0 ? 255 : 0);
  const simulation::TexturePool pool({simulation::Texture(kSize, pixels)});
  const ShapeBank shapes(1, Random(1));
  LayeredScene scene;
  scene.camera = test_camera();
  Layer layer;
  layer.plane = layer.origin = Eigen::Vector3d::UnitZ();
  layer.tile_axis_u *= scene.camera.fx * texels_per_pixel / kSize;
  layer.tile_axis_v *= scene.camera.fy * texels_per_pixel / kSize;
  scene.layers.push_back(layer);
  LayerView view;
  LayerRenderer(pool, shapes).render(scene, {project_layer(layer, scene.camera, {})}, 0.0F, view);
  return view.grey;
}

TEST(LayerRenderer, DoesNotAliasWhatIsFinerThanPixels) {
  for (const double texels_per_pixel : {2.0, 2.9, 7.3}) {
    for (const float grey : checkerboard_view(texels_per_pixel))
      ASSERT_NEAR(grey, 127.5F, 1.0F) << texels_per_pixel;
  }
}

TEST(LayerRenderer, ShowsWhatIsCoarserThanPixels) {
  const std::vector<float> grey = checkerboard_view(0.1);
  EXPECT_LT(*std::min_element(grey.begin(), grey.end()), 20.0F);
  EXPECT_GT(*std::max_element(grey.begin(), grey.end()), 235.0F);
}

// A white box in front of black, its border across pixels: grey levels tell the covered area.
TEST(LayerRenderer, SmoothsEdgesByTheCoveredArea) {
  const simulation::TexturePool pool(
      {simulation::Texture(2, {255, 255, 255, 255}), simulation::Texture(2, {0, 0, 0, 0})});
  LayeredScene scene;
  scene.camera = test_camera();
  // Two endless planes that meet in the column 100.3: white is nearer to the left of it.
  const double slope = 1.0 / scene.camera.fx;
  Layer white;
  white.plane = {-1.0, 0.0, 1.0 + slope * (100.3 - scene.camera.cx)};
  white.origin = white.plane / white.plane.squaredNorm();
  Layer black;
  black.texture = 1;
  black.plane = black.origin = Eigen::Vector3d::UnitZ();
  scene.layers = {white, black};
  LayerImages images;
  for (const Layer& layer : scene.layers) images.push_back(project_layer(layer, scene.camera, {}));
  LayerView view;
  LayerRenderer(pool, ShapeBank(1, Random(1))).render(scene, images, 0.0F, view);
  for (int row = 0; row < scene.camera.height; ++row) {
    const float* at = view.grey.data() + row * scene.camera.width;
    EXPECT_EQ(at[99], 255.0F);
    EXPECT_NEAR(at[100], 0.8F * 255.0F, 255.0F / 8.0F);
    EXPECT_EQ(at[101], 0.0F);
  }
}

TEST(ShapeBank, ShapesHaveAnInsideAndAnOutside) {
  const ShapeBank shapes(60, Random(3));
  ASSERT_EQ(shapes.size(), 60U);
  for (std::size_t shape = 0; shape < shapes.size(); ++shape) {
    int inside = 0;
    for (double s = -0.95; s < 1.0; s += 0.1) {
      for (double t = -0.95; t < 1.0; t += 0.1) inside += shapes.inside(shape, s, t) ? 1 : 0;
    }
    EXPECT_GT(inside, 10) << shape;
    EXPECT_LT(inside, 400) << shape;
    EXPECT_FALSE(shapes.inside(shape, 1.01, 0.0));
    EXPECT_FALSE(shapes.inside(shape, 0.0, -1.01));
  }
}

}  // namespace
}  // namespace imslam::training
