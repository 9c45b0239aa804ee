#include "slam/training/triplet_generator.hpp"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <optional>

#include "slam/base/config.hpp"
#include "slam/base/error.hpp"
#include "slam/base/parallel.hpp"
#include "slam/training/augmentation.hpp"
#include "tests/slam/training/samples.hpp"

namespace imslam::training {
namespace {

constexpr std::uint64_t kSamples = 10;

TEST(TripletGenerator, Right0AtTheDisparityShowsLeft0) {
  for (std::uint64_t i = 0; i < kSamples; ++i) {
    const std::vector<double> residuals = stereo_residuals(quick_generator().make(i));
    EXPECT_GT(residuals.size(), 20000U) << i;
    EXPECT_LT(quantile(residuals, 0.5), 1.0) << i;
    EXPECT_LT(quantile(residuals, 0.9), 8.0) << i;
  }
}

TEST(TripletGenerator, Left1AtTheFlowShowsLeft0) {
  for (std::uint64_t i = 0; i < kSamples; ++i) {
    const Triplet triplet = quick_generator().make(i);
    const std::vector<double> residuals = flow_residuals(triplet);
    EXPECT_LT(quantile(residuals, 0.5), 1.0) << i;
    // What is left is the error of looking between pixels; half a pixel beside, it is far more.
    const double most = quantile(residuals, 0.9);
    EXPECT_LT(most, 15.0) << i;
    EXPECT_LT(1.5 * most, quantile(flow_residuals(triplet, 0.5), 0.9)) << i;
  }
}

TEST(TripletGenerator, StereoMatchesLieOnTheSameRow) {
  for (std::uint64_t i = 0; i < kSamples; ++i) {
    const Triplet triplet = quick_generator().make(i);
    const double on_row = quantile(stereo_residuals(triplet), 0.8);
    EXPECT_LT(on_row, quantile(stereo_residuals(triplet, 0.5), 0.8)) << i;
    EXPECT_LT(on_row, quantile(stereo_residuals(triplet, -0.5), 0.8)) << i;
  }
}

TEST(TripletGenerator, DisparityIsPositiveAndTruthIsFinite) {
  for (std::uint64_t i = 0; i < kSamples; ++i) {
    const Triplet triplet = quick_generator().make(i);
    for (std::size_t at = 0; at < triplet.disparity.size(); ++at) {
      ASSERT_GT(triplet.disparity[at], 0.0F) << i;
      ASSERT_LT(triplet.disparity[at], 400.0F) << i;
      ASSERT_TRUE(std::isfinite(triplet.flow_u[at]) && std::isfinite(triplet.flow_v[at])) << i;
      for (const std::vector<float>* view : {&triplet.left0, &triplet.right0, &triplet.left1}) {
        ASSERT_GE((*view)[at], 0.0F);
        ASSERT_LE((*view)[at], 255.0F);
      }
    }
  }
}

// Where nothing moves by itself, the flow is that of the points that the disparity tells.
TEST(TripletGenerator, FlowOfAStillWorldFollowsFromDisparityAndMotion) {
  TripletOptions options = quick_options();
  options.texture_count = 2;
  options.scene.moving_share = 0.0;
  const TripletGenerator generator(options);
  for (std::uint64_t i = 0; i < 5; ++i) {
    const Triplet t = generator.make(i);
    for (int row = 0; row < t.camera.height; row += 7) {
      for (int column = 0; column < t.camera.width; column += 7) {
        const std::size_t at = t.index(row, column);
        if (t.flow_state[at] == MatchState::kNone) continue;
        const Eigen::Vector3d p_left0 =
            t.camera.back_project({1.0 * column, 1.0 * row, double{t.disparity[at]}});
        const Eigen::Vector3d pixel = t.camera.project(t.T_left1_left0 * p_left0);
        EXPECT_NEAR(column + double{t.flow_u[at]}, pixel.x(), 2e-3);
        EXPECT_NEAR(row + double{t.flow_v[at]}, pixel.y(), 2e-3);
      }
    }
  }
}

TEST(TripletGenerator, ARestingCameraSeesTheSameTwice) {
  TripletOptions options = quick_options();
  options.texture_count = 2;
  options.scene.moving_share = 0.0;
  options.scene.still_share = 1.0;
  const Triplet t = TripletGenerator(options).make(3);
  EXPECT_EQ(t.left0, t.left1);
  EXPECT_LT(*std::max_element(t.flow_u.begin(), t.flow_u.end()), 1e-6F);
  for (const MatchState state : t.flow_state) ASSERT_EQ(state, MatchState::kVisible);
}

struct Hit {
  std::size_t layer = 0;
  double z = 0.0;  ///< [m] along the camera's axis
};

/// The slow, obvious way: intersects the ray through a pixel with every plane, in its own frame.
std::optional<Hit> cast(const LayeredScene& scene,
                        const std::vector<lie::SE3d>& T_camera_layers,
                        const Eigen::Vector2d& pixel) {
  const StereoCamera& c = scene.camera;
  const Eigen::Vector3d ray((pixel.x() - c.cx) / c.fx, (pixel.y() - c.cy) / c.fy, 1.0);
  std::optional<Hit> nearest;
  for (std::size_t i = 0; i < scene.layers.size(); ++i) {
    const Layer& layer = scene.layers[i];
    const lie::SE3d T_layer_camera = T_camera_layers[i].inverse();
    const Eigen::Vector3d start = T_layer_camera.translation();
    const Eigen::Vector3d direction = T_layer_camera.rotation() * ray;
    const double z = (1.0 - layer.plane.dot(start)) / layer.plane.dot(direction);
    if (!(z > 0.0) || (nearest && z >= nearest->z)) continue;
    const Eigen::Vector3d from_origin = start + z * direction - layer.origin;
    const bool seen = layer.shape == Layer::kEndless ||
                      quick_generator().shapes().inside(static_cast<std::size_t>(layer.shape),
                                                        layer.axis_s.dot(from_origin),
                                                        layer.axis_t.dot(from_origin));
    if (seen) nearest = Hit{i, z};
  }
  return nearest;
}

/// Whether a small step changes what is seen: there rounding may decide.
bool at_edge(const LayeredScene& scene,
             const std::vector<lie::SE3d>& T_camera_layers,
             const Eigen::Vector2d& pixel) {
  const std::optional<Hit> centre = cast(scene, T_camera_layers, pixel);
  for (const double dx : {-1e-3, 1e-3}) {
    for (const double dy : {-1e-3, 1e-3}) {
      const auto beside = cast(scene, T_camera_layers, pixel + Eigen::Vector2d(dx, dy));
      if (!beside || beside->layer != centre->layer) return true;
    }
  }
  return false;
}

MatchState expected_state(const LayeredScene& scene,
                          const std::vector<lie::SE3d>& T_camera_layers,
                          const Eigen::Vector2d& pixel,
                          std::size_t layer) {
  const Eigen::AlignedBox2d image(
      Eigen::Vector2d(-1e-6, -1e-6),
      Eigen::Vector2d(scene.camera.width - 1 + 1e-6, scene.camera.height - 1 + 1e-6));
  if (!image.contains(pixel)) return MatchState::kOutside;
  const std::optional<Hit> hit = cast(scene, T_camera_layers, pixel);
  return hit && hit->layer == layer ? MatchState::kVisible : MatchState::kHidden;
}

/// Where the layers of a scene are against the three cameras.
struct Stations {
  std::vector<lie::SE3d> left0, right0, left1;

  explicit Stations(const LayeredScene& scene) : left0(scene.layers.size()) {
    for (const Layer& layer : scene.layers) {
      right0.push_back(scene.T_right0_left0());
      left1.push_back(scene.T_left1_layer(layer));
    }
  }
};

TEST(TripletGenerator, DisplacementsAndMatchStatesAgreeWithRayCasting) {
  Random random(4);
  int compared = 0;
  int hidden = 0;
  for (std::uint64_t i = 0; i < kSamples; ++i) {
    const LayeredScene scene = quick_generator().scene(i);
    const Triplet t = quick_generator().make(i);
    const Stations stations(scene);
    for (int k = 0; k < 300; ++k) {
      const int column = static_cast<int>(random.integer(0, t.camera.width - 1));
      const int row = static_cast<int>(random.integer(0, t.camera.height - 1));
      const std::size_t at = t.index(row, column);
      const std::optional<Hit> hit = cast(scene, stations.left0, {column, row});
      ASSERT_TRUE(hit);
      if (at_edge(scene, stations.left0, {column, row})) continue;
      const Eigen::Vector3d p_left0 = scene.camera.back_project(
          {1.0 * column, 1.0 * row, scene.camera.fx * scene.camera.baseline_m / hit->z});
      const Eigen::Vector2d right = {column - scene.camera.project(p_left0).z(), row};
      EXPECT_NEAR(column - double{t.disparity[at]}, right.x(), 1e-4);
      if (right.x() < 0.0 || !at_edge(scene, stations.right0, right)) {
        EXPECT_EQ(t.disparity_state[at], expected_state(scene, stations.right0, right, hit->layer))
            << i << " " << column << " " << row;
        hidden += t.disparity_state[at] == MatchState::kHidden ? 1 : 0;
      }
      const Eigen::Vector3d p_left1 = stations.left1[hit->layer] * p_left0;
      if (p_left1.z() < 0.01 * p_left0.z()) continue;
      const Eigen::Vector2d next = scene.camera.project(p_left1).head<2>();
      EXPECT_NEAR(column + double{t.flow_u[at]}, next.x(), 1e-4);
      EXPECT_NEAR(row + double{t.flow_v[at]}, next.y(), 1e-4);
      if (!at_edge(scene, stations.left1, next)) {
        EXPECT_EQ(t.flow_state[at], expected_state(scene, stations.left1, next, hit->layer))
            << i << " " << column << " " << row;
        hidden += t.flow_state[at] == MatchState::kHidden ? 1 : 0;
      }
      ++compared;
    }
  }
  EXPECT_GT(compared, 2500);
  EXPECT_GT(hidden, 50);
}

TEST(TripletGenerator, SamplesAreTheSameForAnyThreadsAndAnyOrder) {
  set_thread_count(1);
  const std::vector<Triplet> alone = quick_generator().batch(20, 4);
  set_thread_count(2);
  const std::vector<Triplet> together = quick_generator().batch(20, 4);
  const TripletGenerator again(quick_options());
  set_thread_count(0);
  Triplet reused = quick_generator().make(99);
  for (std::size_t i = alone.size(); i-- > 0;) {
    EXPECT_TRUE(same(alone[i], together[i])) << i;
    again.make(20 + i, reused);
    EXPECT_TRUE(same(alone[i], reused)) << i;
  }
  EXPECT_FALSE(same(alone[0], alone[1]));
}

TEST(TripletGenerator, AnotherSeedGivesOtherSamples) {
  TripletOptions options = quick_options();
  options.seed = 2;
  EXPECT_NE(TripletGenerator(options).make(0).left0, quick_generator().make(0).left0);
}

TEST(TripletGenerator, MakesImagesOfOtherSizes) {
  TripletOptions options = quick_options();
  options.texture_count = 2;
  options.scene.width = 208;
  options.scene.height = 160;
  options.scene.rotation_flow = 40.0;
  const Triplet triplet = TripletGenerator(options).make(1);
  EXPECT_EQ(triplet.left0.size(), 208U * 160U);
  EXPECT_LT(quantile(stereo_residuals(triplet), 0.5), 1.0);
}

// Else there would be pixels that see nothing.
TEST(TripletGenerator, TheFarthestLayerIsInFrontOfEveryCamera) {
  SceneOptions options;
  options.rotation_flow = 0.25 * options.width;
  options.parallax_flow = 0.25 * options.width;
  options.validate();
  const SceneStock stock{{{512, 0.5, 0.2, 0.05}}, 1};
  for (std::uint64_t i = 0; i < 3000; ++i) {
    const LayeredScene scene = draw_scene(options, stock, Random(i));
    const Stations stations(scene);
    const StereoCamera& c = scene.camera;
    for (const lie::SE3d& T : {stations.right0.back(), stations.left1.back()}) {
      const LayerImage image = project_layer(scene.layers.back(), c, T);
      for (const double u : {-0.5, c.width - 0.5}) {
        for (const double v : {-0.5, c.height - 0.5})
          ASSERT_GT(image.inverse_depth.dot(Eigen::Vector3d(u, v, 1.0)), 0.0) << i;
      }
    }
  }
}

TEST(TripletGenerator, OptionsCanBeSetByName) {
  TripletOptions options;
  AugmentationOptions augmentation;
  Config config;
  config.section("triplets", options);
  config.section("augmentation", augmentation);
  config.set("triplets.scene.moving_share=0.5", "test");
  config.set("augmentation.darkest=0.1", "test");
  EXPECT_EQ(options.scene.moving_share, 0.5);
  EXPECT_EQ(augmentation.darkest, 0.1);
}

TEST(TripletGenerator, RefusesOptionsThatMakeNoSense) {
  TripletOptions options = quick_options();
  options.scene.width = 380;
  EXPECT_THROW(TripletGenerator{options}, InputError);
  options = quick_options();
  options.scene.most_disparity = 2.0;
  EXPECT_THROW(TripletGenerator{options}, InputError);
  options = quick_options();
  options.texture_count = 0;
  EXPECT_THROW(TripletGenerator{options}, InputError);
}

}  // namespace
}  // namespace imslam::training
