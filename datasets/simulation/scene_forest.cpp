#include <algorithm>
#include <cmath>

#include "datasets/simulation/furniture.hpp"
#include "datasets/simulation/paths.hpp"
#include "datasets/simulation/scene.hpp"
#include "datasets/simulation/vegetation.hpp"

namespace imslam::simulation {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;

constexpr double kHalfSize = 60.0;  ///< [m] of the wood
constexpr double kFar = 7.0;        ///< [m] from the path where leaves are too small to see
constexpr double kFree = 1.1;       ///< [m] around the path that trunks keep clear of

/// Rolling ground that rises towards the edge of the wood and closes the view.
class Ground {
 public:
  explicit Ground(Random& random)
      : east_(random, 0.45, 0.01, 0.06),
        north_(random, 0.45, 0.01, 0.06),
        fine_(random, 0.05, 0.1, 0.5) {}

  double operator()(double x, double y) const {
    const double edge = std::max(0.0, std::hypot(x, y) - 0.62 * kHalfSize);
    return east_(x) + north_(y) + fine_(x + 0.7 * y) + 0.012 * edge * edge;
  }

 private:
  Wobble east_;
  Wobble north_;
  Wobble fine_;
};

/// A closed way that winds around a rough circle.
PlanarLoop trail(Random& random) {
  const double radius = random.uniform(14.0, 20.0);
  double amplitudes[7];
  double phases[7];
  for (int k = 0; k < 7; ++k) {
    amplitudes[k] = random.uniform(0.3, 1.0);
    phases[k] = random.uniform(0, 2 * M_PI);
  }
  std::vector<Vector2d> points;
  for (int i = 0; i < 600; ++i) {
    const double angle = 2 * M_PI * i / 600;
    double bend = 0.0;
    for (int k = 0; k < 7; ++k)
      bend += amplitudes[k] * std::cos((k + 2) * angle + phases[k]) / (k + 2.5);
    const double r = radius * (1.0 + 0.22 * bend);
    points.emplace_back(r * std::cos(angle), r * std::sin(angle));
  }
  if (random.chance(0.5)) std::reverse(points.begin(), points.end());
  PlanarLoop::Limits limits;
  limits.speed = 1.7;
  limits.turn_rate = 0.8;
  limits.smoothing_m = 1.2;
  return PlanarLoop(points, limits);
}

void plant(Scene& scene,
           const PlanarLoop& loop,
           const Ground& ground,
           const Vegetation& plants,
           Random& random) {
  struct Kind {
    const std::vector<std::size_t>& prototypes;
    const std::vector<std::size_t>& far_prototypes;  ///< as many as prototypes
    int count;
    double reach;      ///< [m] half size of the area
    double clearance;  ///< [m] from the path
    double smallest;
    double largest;
  };
  const Kind kinds[] = {{plants.broadleaves, plants.far_broadleaves, 170, 48.0, kFree, 0.85, 1.3},
                        {plants.conifers, plants.far_conifers, 170, 48.0, 3.1, 0.7, 1.3},
                        {plants.bushes, plants.far_bushes, 170, 40.0, kFree + 0.8, 0.5, 1.3},
                        {plants.stones, plants.stones, 120, 34.0, 0.7, 0.4, 1.3},
                        {plants.ferns, plants.ferns, 480, 28.0, 0.45, 0.5, 1.3},
                        {plants.logs, plants.logs, 26, 34.0, 1.9, 0.7, 1.2}};
  for (const Kind& kind : kinds) {
    for (int i = 0; i < kind.count; ++i) {
      const double x = random.uniform(-kind.reach, kind.reach);
      const double y = random.uniform(-kind.reach, kind.reach);
      const double yaw = random.uniform(0, 2 * M_PI);
      const double scale = random.uniform(kind.smallest, kind.largest);
      const auto pick = random.integer(0, static_cast<std::int64_t>(kind.prototypes.size()) - 1);
      const double clearance = loop.clearance({x, y});
      if (clearance < kind.clearance * std::max(1.0, scale)) continue;
      const auto& choice = clearance > kFar ? kind.far_prototypes : kind.prototypes;
      scene.instances.push_back({choice[static_cast<std::size_t>(pick)],
                                 upright(x, y, ground(x, y) - 0.04, yaw),
                                 scale,
                                 {}});
    }
  }
}

std::function<lie::SE3d(double)> stroll(const PlanarLoop& loop,
                                        const Ground& ground,
                                        Random& random) {
  const Wobble gaze(random, 0.45, 0.04, 0.18);
  const Wobble pitch(random, 0.14, 0.06, 0.4);
  const Wobble roll(random, 0.12, 0.08, 0.5);
  const Wobble height(random, 0.25, 0.04, 0.2);
  const double step_phase = random.uniform(0, 2 * M_PI);
  return [=](double t) {
    const PlanarLoop::Pose at = loop.at_time(t);
    const double step = 2 * M_PI * at.distance / 0.85 + step_phase;
    const double z = ground(at.position.x(), at.position.y()) + 1.6 + height(t);
    const Vector3d position(at.position.x(), at.position.y(), z + 0.02 * std::sin(step));
    const double sway = 0.018 * std::sin(0.5 * step);
    const lie::SO3d R = lie::SO3d::exp({0, 0, at.yaw + gaze(t) + sway}) *
                        lie::SO3d::exp({0, 0.02 + pitch(t) + 0.01 * std::cos(step), 0}) *
                        lie::SO3d::exp({roll(t) + sway, 0, 0});
    return lie::SE3d(R, position);
  };
}

void light(Scene& scene, Random& random) {
  const double azimuth = random.uniform(0, 2 * M_PI);
  const double rise = random.uniform(0.7, 1.2);
  scene.lighting.ambient = 0.42F;
  scene.lighting.sun = 0.75F;
  scene.lighting.to_sun = Vector3d(std::cos(azimuth) * std::cos(rise),
                                   std::sin(azimuth) * std::cos(rise), std::sin(rise))
                              .cast<float>();
}

}  // namespace

Scene make_forest(TextureBank& bank, Random random) {
  Scene scene;
  scene.sky_texture = scene.paint(bank, Material::kSky, 1.0, random).texture;
  const Ground ground(random);
  const PlanarLoop loop = trail(random);
  const Paint soil = scene.paint(bank, Material::kGround, 2.6, random);
  scene.fixed.add_terrain(
      {-kHalfSize, -kHalfSize}, {kHalfSize, kHalfSize}, 0.5,
      [&](double x, double y) { return ground(x, y); }, soil);
  const Vegetation plants = grow_vegetation(scene, bank, random);
  plant(scene, loop, ground, plants, random);
  light(scene, random);
  scene.path = stroll(loop, ground, random);
  return scene;
}

}  // namespace imslam::simulation
