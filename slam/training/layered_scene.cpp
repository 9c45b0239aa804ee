#include "slam/training/layered_scene.hpp"

#include <algorithm>
#include <cmath>

#include "slam/base/error.hpp"

namespace imslam::training {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;

double log_uniform(Random& random, double low, double high) {
  return std::exp(random.uniform(std::log(low), std::log(high)));
}

StereoCamera draw_camera(const SceneOptions& options, Random& random) {
  StereoCamera camera;
  camera.width = options.width;
  camera.height = options.height;
  camera.fx = options.width * log_uniform(random, 0.55, 1.4);
  camera.fy = camera.fx * random.uniform(0.98, 1.02);
  camera.cx = 0.5 * (options.width - 1) + 0.06 * options.width * random.uniform(-1.0, 1.0);
  camera.cy = 0.5 * (options.height - 1) + 0.06 * options.height * random.uniform(-1.0, 1.0);
  camera.baseline_m = log_uniform(random, 0.06, 0.6);
  return camera;
}

/// The range of disparities in a scene [px].
struct DepthRange {
  double near_disparity = 0.0;
  double far_disparity = 0.0;
};

DepthRange draw_range(const SceneOptions& options, Random& random) {
  DepthRange range;
  range.near_disparity = log_uniform(random, options.least_disparity, options.most_disparity);
  range.far_disparity = std::max(0.2, range.near_disparity * log_uniform(random, 0.03, 0.6));
  return range;
}

/// Puts planes into the frame of left0.
class LayerPainter {
 public:
  LayerPainter(const StereoCamera& camera, const SceneStock& stock, Random& random)
      : camera_(camera), stock_(stock), random_(random) {}

  double depth(double disparity) const { return camera_.fx * camera_.baseline_m / disparity; }

  Vector3d ray(double u, double v) const {
    return {(u - camera_.cx) / camera_.fx, (v - camera_.cy) / camera_.fy, 1.0};
  }

  /// An endless plane; the texture has its chosen scale where the plane is `depth_m` away.
  Layer endless(const Vector3d& plane, double depth_m) {
    Layer layer;
    layer.plane = plane;
    layer.origin = plane / plane.squaredNorm();  // the foot of the perpendicular
    paint(layer, depth_m);
    return layer;
  }

  /// A cut-out about the pixel (u, v), tilted at random; `half` extents [px].
  Layer cut_out(double u, double v, double disparity, const Vector2d& half) {
    const double z = depth(disparity);
    const Vector3d towards = ray(u, v);
    Layer layer;
    const auto tilt = [&] { return std::clamp(0.45 * random_.normal(), -1.2, 1.2); };
    Vector3d normal = Vector3d{tilt(), tilt(), 1.0}.normalized();
    if (normal.dot(towards) < 0.3 * towards.norm()) normal = Vector3d::UnitZ();
    layer.origin = z * towards;
    layer.plane = normal / normal.dot(layer.origin);
    const auto [e1, e2] = basis_of(normal, 0.7 * random_.normal());
    layer.axis_s = e1 * camera_.fx / (z * half.x());
    layer.axis_t = e2 * camera_.fx / (z * half.y());
    layer.shape = static_cast<int>(random_.integer(0, static_cast<int>(stock_.shapes) - 1));
    paint(layer, z);
    return layer;
  }

 private:
  struct Basis {
    Vector3d e1, e2;
  };

  /// Right and down in the plane where the plane faces the camera, then turned by `angle`.
  static Basis basis_of(const Vector3d& normal, double angle) {
    const Vector3d other =
        std::abs(normal.y()) < 0.9 * normal.norm() ? Vector3d::UnitY() : Vector3d::UnitZ();
    const Vector3d right = other.cross(normal).normalized();
    const Vector3d down = normal.normalized().cross(right);
    return {std::cos(angle) * right + std::sin(angle) * down,
            std::cos(angle) * down - std::sin(angle) * right};
  }

  std::size_t draw_texture() {
    return static_cast<std::size_t>(
        random_.integer(0, static_cast<std::int64_t>(stock_.textures.size()) - 1));
  }

  void paint(Layer& layer, double depth_m) {
    // Most surfaces show detail, none too much: plain textures are passed over, faint ones get more
    // contrast, glaring ones less. Some stay as they are: a matcher must know when it sees nothing.
    constexpr double kLively = 0.045;
    constexpr double kMostBoost = 3.0;
    const bool lively = random_.chance(0.85);
    layer.texture = draw_texture();
    for (int i = 0; lively && i < 4; ++i) {
      if (stock_.textures[layer.texture].detail * kMostBoost >= kLively) break;
      layer.texture = draw_texture();
    }
    const TextureFacts& texture = stock_.textures[layer.texture];
    const double boost =
        lively ? std::clamp(kLively / std::max(texture.detail, 1e-4), 0.5, kMostBoost) : 1.0;
    constexpr double kMostDeviation = 0.2;  // more would be black and white only
    layer.gain = std::min(boost, kMostDeviation / std::max(texture.deviation, 1e-4)) *
                 random_.uniform(0.45, 1.1);
    layer.offset = random_.uniform(0.25, 0.75) - layer.gain * texture.mean;
    const double texels_per_pixel = log_uniform(random_, 0.5, 3.0);
    const double tiles_per_m = texels_per_pixel * camera_.fx / (depth_m * texture.size);
    const auto [e1, e2] = basis_of(layer.plane, random_.uniform(-M_PI, M_PI));
    layer.tile_axis_u = tiles_per_m * e1;
    layer.tile_axis_v = tiles_per_m * (random_.chance(0.5) ? e2 : Vector3d(-e2));
    layer.tile_offset.x() = random_.uniform();
    layer.tile_offset.y() = random_.uniform();
  }

  const StereoCamera& camera_;
  const SceneStock& stock_;
  Random& random_;
};

/// The inside of a box that is turned a little against the camera: floor, walls, ceiling.
void draw_walls(const StereoCamera& camera,
                const DepthRange& range,
                Random& random,
                LayerPainter& painter,
                std::vector<Layer>& layers) {
  const Vector3d turn{random.uniform(-0.25, 0.25), random.uniform(-0.5, 0.5),
                      0.1 * random.normal()};
  const lie::SO3d R = lie::SO3d::exp(turn);
  const double painted = 0.5 * range.near_disparity;  // neither blurred nearby nor grey far away
  // A plane parallel to the view that has the disparity where the image ends.
  const auto side = [&](const Vector3d& normal, double tangent) {
    const double disparity = range.near_disparity * log_uniform(random, 0.3, 1.0);
    const double distance = painter.depth(disparity) * std::max(tangent, 0.1);
    layers.push_back(painter.endless(Vector3d(R * normal) / distance, painter.depth(painted)));
  };
  if (random.chance(0.85)) side(Vector3d::UnitY(), (camera.height - camera.cy) / camera.fy);
  if (random.chance(0.3)) side(-Vector3d::UnitY(), camera.cy / camera.fy);
  if (random.chance(0.4)) side(Vector3d::UnitX(), (camera.width - camera.cx) / camera.fx);
  if (random.chance(0.4)) side(-Vector3d::UnitX(), camera.cx / camera.fx);
  const double far_m = painter.depth(range.far_disparity);
  layers.push_back(painter.endless(Vector3d(R * Vector3d::UnitZ()) / far_m, far_m));
}

void draw_backdrop(const DepthRange& range,
                   Random& random,
                   LayerPainter& painter,
                   std::vector<Layer>& layers) {
  const double far_m = painter.depth(range.far_disparity);
  const Vector3d slanted{0.3 * random.normal(), 0.3 * random.normal(), 1.0};
  layers.push_back(painter.endless(slanted / far_m, far_m));
}

lie::SE3d draw_own_motion(const Layer& layer,
                          const SceneOptions& options,
                          const StereoCamera& camera,
                          Random& random) {
  const double m_per_px = layer.origin.z() / camera.fx;
  const double sideways = options.object_flow * m_per_px;
  const Vector3d t{sideways * random.normal(), sideways * random.normal(),
                   layer.origin.z() * random.uniform(-0.1, 0.1)};
  const lie::SO3d R = lie::SO3d::exp(Vector3d(0.1 * random.normal3()));
  return lie::SE3d(R, layer.origin + t - R * layer.origin);
}

void draw_cut_outs(const SceneOptions& options,
                   const StereoCamera& camera,
                   const DepthRange& range,
                   Random& random,
                   LayerPainter& painter,
                   std::vector<Layer>& layers) {
  const int count = static_cast<int>(log_uniform(random, 3.0, 22.0));
  const double least = std::min(1.3 * range.far_disparity, range.near_disparity);
  for (int i = 0; i < count; ++i) {
    const double u = camera.width * random.uniform(-0.1, 1.1);
    const double v = camera.height * random.uniform(-0.1, 1.1);
    const double disparity = log_uniform(random, least, range.near_disparity);
    const double half = log_uniform(random, 0.03, 0.33) * camera.width;
    const double aspect = log_uniform(random, 0.6, 1.6);
    Layer layer = painter.cut_out(u, v, disparity, {half * aspect, half / aspect});
    if (random.chance(options.moving_share))
      layer.motion = draw_own_motion(layer, options, camera, random);
    layers.push_back(layer);
  }
}

/// Small motions are commoner than large ones; a scene is turned, moved, or both.
lie::SE3d draw_motion(const SceneOptions& options,
                      const StereoCamera& camera,
                      double nearest_m,
                      Random& random) {
  if (random.chance(options.still_share)) return {};
  const double turning = std::pow(random.uniform(), 2);
  const double moving = std::pow(random.uniform(), 2);
  const double heading = random.uniform(-M_PI, M_PI);
  const double angle = turning * options.rotation_flow / camera.fx;
  const Vector3d theta(0.6 * angle * std::sin(heading), angle * std::cos(heading),
                       0.12 * (0.2 + turning) * random.normal());
  const double direction = random.uniform(-M_PI, M_PI);
  const double sideways_m = moving * options.parallax_flow * nearest_m / camera.fx;
  const Vector3d t(sideways_m * std::cos(direction), 0.5 * sideways_m * std::sin(direction),
                   0.3 * nearest_m * moving * random.uniform(-1.0, 1.0));
  return lie::SE3d(lie::SO3d::exp(theta), t);
}

}  // namespace

lie::SE3d LayeredScene::T_right0_left0() const {
  return lie::SE3d(lie::SO3d(), Vector3d(-camera.baseline_m, 0.0, 0.0));
}

LayeredScene draw_scene(const SceneOptions& options, const SceneStock& stock, Random random) {
  expects(!stock.textures.empty() && stock.shapes > 0,
          "draw_scene: textures and shapes are needed");
  LayeredScene scene;
  scene.camera = draw_camera(options, random);
  const DepthRange range = draw_range(options, random);
  LayerPainter painter(scene.camera, stock, random);
  if (random.chance(0.6)) {
    draw_walls(scene.camera, range, random, painter, scene.layers);
  } else {
    draw_backdrop(range, random, painter, scene.layers);
  }
  draw_cut_outs(options, scene.camera, range, random, painter, scene.layers);
  std::stable_sort(scene.layers.begin(), scene.layers.end(), [](const Layer& a, const Layer& b) {
    return a.origin.squaredNorm() < b.origin.squaredNorm();
  });
  // Behind everything, where walls are open.
  const double far_m = painter.depth(0.3 * range.far_disparity);
  scene.layers.push_back(painter.endless(Vector3d::UnitZ() / far_m, far_m));
  scene.T_left1_left0 =
      draw_motion(options, scene.camera, painter.depth(range.near_disparity), random);
  return scene;
}

}  // namespace imslam::training
