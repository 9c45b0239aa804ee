#include <algorithm>
#include <array>
#include <cmath>

#include "datasets/simulation/buildings.hpp"
#include "datasets/simulation/paths.hpp"
#include "datasets/simulation/scene.hpp"
#include "datasets/simulation/vegetation.hpp"
#include "datasets/simulation/vehicle.hpp"

namespace imslam::simulation {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;

// Distances from the middle of the road [m].
constexpr double kLane = 1.75;     ///< middle of a lane
constexpr double kParking = 4.45;  ///< middle of the row of parked cars
constexpr double kKerb = 5.6;
constexpr double kTrees = 6.4;
constexpr double kFacades = 9.0;
constexpr double kCorner = 9.0;  ///< radius of the road's middle line in the corners

/// The road is a rounded rectangle about the origin, driven counter-clockwise on the right.
struct Block {
  double half_x;  ///< [m] of the middle line
  double half_y;
};

std::vector<Vector2d> ring(const Block& block, double offset) {
  const double radius = std::max(0.3, kCorner + offset);
  const double x = block.half_x + offset - radius;
  const double y = block.half_y + offset - radius;
  std::vector<Vector2d> points;
  add_arc(points, {x, -y}, radius, -M_PI / 2, 0.0);
  add_arc(points, {x, y}, radius, 0.0, M_PI / 2);
  add_arc(points, {-x, y}, radius, M_PI / 2, M_PI);
  add_arc(points, {-x, -y}, radius, M_PI, 3 * M_PI / 2);
  return points;
}

PlanarLoop lane(const Block& block, double offset, double speed) {
  std::vector<Vector2d> points = ring(block, offset);
  if (offset < 0.0) std::reverse(points.begin(), points.end());
  PlanarLoop::Limits limits;
  limits.speed = speed;
  limits.turn_rate = 0.55;
  limits.lateral_accel = 2.5;
  limits.smoothing_m = 5.0;
  return PlanarLoop(points, limits);
}

/// The four straight sides: origin in the middle of the road's line, x along the driving direction,
/// y towards the inner block.
std::array<lie::SE3d, 4> sides_of(const Block& block) {
  return {upright(0, -block.half_y, 0, 0.0), upright(block.half_x, 0, 0, M_PI / 2),
          upright(0, block.half_y, 0, M_PI), upright(-block.half_x, 0, 0, -M_PI / 2)};
}

double half_length(const Block& block, std::size_t side) {
  return side % 2 == 0 ? block.half_x : block.half_y;
}

void add_ground(Scene& scene, const Block& block, TextureBank& bank, Random& random) {
  const Paint asphalt = scene.paint(bank, Material::kAsphalt, 5.0, random);
  const Paint paving = scene.paint(bank, Material::kTiles, 2.4, random);
  const Paint far_ground = scene.paint(bank, Material::kConcrete, 9.0, random);
  const Paint marking = scene.paint(bank, Material::kPlaster, 1.5, random);
  const double x = block.half_x + 30.0;
  const double y = block.half_y + 30.0;
  scene.fixed.add_quad({-x, -y, 0}, {2 * x, 0, 0}, {0, 2 * y, 0}, asphalt, 0.6);
  scene.fixed.add_quad({-250, -250, -0.1}, {500, 0, 0}, {0, 500, 0}, far_ground, 10.0);
  for (std::size_t k = 0; k < 4; ++k) {
    const lie::SE3d side = sides_of(block)[k];
    const double half = half_length(block, k) - kCorner;
    for (const double way : {-1.0, 1.0}) {
      const double middle = way * 0.5 * (kKerb + kFacades);
      const double length = 2 * half + (way < 0.0 ? 2 * kCorner : -2.0);
      scene.fixed.add_box(side * upright(0, middle, 0.06, 0), {length, kFacades - kKerb, 0.14},
                          paving, false, 0.7);
    }
    const lie::SO3d& R = side.rotation();
    for (double s = -half; s < half; s += 6.0) {
      scene.fixed.add_quad(side * Vector3d(s, -0.07, 0.012), R * Vector3d(3, 0, 0),
                           R * Vector3d(0, 0.14, 0), marking, 1.0);
    }
    for (double w = -4.2; w < 4.2; w += 0.95) {  // a crossing
      scene.fixed.add_quad(side * Vector3d(0.3 * half, w, 0.014), R * Vector3d(2.6, 0, 0),
                           R * Vector3d(0, 0.5, 0), marking, 0.5);
    }
  }
}

void line_with_buildings(Scene& scene,
                         const Block& block,
                         const BuildingPaints& paints,
                         Random& random) {
  for (std::size_t k = 0; k < 4; ++k) {
    const lie::SE3d side = sides_of(block)[k];
    for (const double way : {-1.0, 1.0}) {
      // Cross streets stay open at the outer corners; the inner block is closed.
      const double half = half_length(block, k) + (way < 0.0 ? -6.0 : -kFacades);
      for (double s = -half; s < half - 5.0;) {
        const double width = std::min(random.uniform(8.0, 16.0), half - s);
        const double setback = random.uniform(0.0, 0.8);
        const double turn = way < 0.0 ? -M_PI / 2 : M_PI / 2;
        add_building(scene.fixed,
                     side * upright(s + 0.5 * width, way * (kFacades + setback), 0.0, turn), width,
                     paints, random);
        s += width + (random.chance(0.25) ? random.uniform(1.0, 3.0) : 0.0);
      }
    }
  }
  add_skyline(scene.fixed, 125.0, paints, random);
}

/// Trees, lamp posts, signs and bins along the kerbs.
void furnish(Scene& scene,
             const Block& block,
             const BuildingPaints& paints,
             const Vegetation& plants,
             Random& random) {
  for (std::size_t k = 0; k < 4; ++k) {
    const lie::SE3d side = sides_of(block)[k];
    const double half = half_length(block, k) - kCorner - 1.0;
    for (const double way : {-1.0, 1.0}) {
      for (double s = -half; s < half; s += random.uniform(4.5, 8.0)) {
        const lie::SE3d place = side * upright(s, way * kTrees, 0.12, way * M_PI / 2);
        const double what = random.uniform();
        if (what < 0.4) {
          const double scale = random.uniform(0.55, 0.8);
          const double yaw = random.uniform(0, 2 * M_PI);
          scene.instances.push_back(
              {plants.broadleaves[what < 0.2 ? 0 : 1], place * upright(0, 0, 0, yaw), scale, {}});
        } else {
          add_street_furniture(scene.fixed, place, paints, random);
        }
      }
    }
  }
}

void park(Scene& scene, const Block& block, const std::vector<std::size_t>& cars, Random& random) {
  for (std::size_t k = 0; k < 4; ++k) {
    const lie::SE3d side = sides_of(block)[k];
    const double half = half_length(block, k) - kCorner - 3.0;
    for (const double way : {-1.0, 1.0}) {
      for (double s = -half; s < half; s += random.uniform(5.2, 6.5)) {
        if (std::abs(s - 0.3 * half) < 4.0 || random.chance(0.3)) continue;
        const auto pick = random.integer(0, static_cast<std::int64_t>(cars.size()) - 1);
        const double yaw = (way > 0.0 ? M_PI : 0.0) + random.uniform(-0.03, 0.03);
        const double off = way * kParking + random.uniform(-0.1, 0.1);
        scene.instances.push_back(
            {cars[static_cast<std::size_t>(pick)], side * upright(s, off, 0.0, yaw), 1.0, {}});
      }
    }
  }
}

/// One car ahead in our lane, others towards us.
void drive(Scene& scene,
           const Block& block,
           const PlanarLoop& own_lane,
           const std::vector<std::size_t>& cars,
           const std::function<double(double)>& travel_time,
           Random& random) {
  const auto pose_on = [](const PlanarLoop& loop, double t) {
    const PlanarLoop::Pose at = loop.at_time(t);
    return upright(at.position.x(), at.position.y(), 0.0, at.yaw);
  };
  const double headway = random.uniform(2.2, 2.9);
  const auto ahead = [=](double t) { return pose_on(own_lane, travel_time(t) + headway); };
  scene.instances.push_back({cars[0], ahead(0.0), 1.0, ahead});
  const PlanarLoop other_lane = lane(block, -kLane, 8.0);
  const int count = 5;
  const double lap = other_lane.lap_time();
  for (int i = 0; i < count; ++i) {
    const double phase = lap * (i + random.uniform(0.15, 0.85)) / count;
    const auto towards = [=](double t) { return pose_on(other_lane, t + phase); };
    scene.instances.push_back(
        {cars[1 + static_cast<std::size_t>(i) % (cars.size() - 1)], towards(0.0), 1.0, towards});
  }
}

std::function<lie::SE3d(double)> ride(const PlanarLoop& loop, Random& random) {
  const Wobble heave(random, 0.02, 0.5, 2.0);
  const Wobble pitch(random, 0.012, 0.4, 1.6);
  const Wobble roll(random, 0.012, 0.4, 1.6);
  return [=](double t) {
    const PlanarLoop::Pose at = loop.at_time(t);
    // Bumps belong to the road: none while the car stands.
    const double bump = 0.125 * at.distance;
    const lie::SO3d R =
        lie::SO3d::exp({0, 0, at.yaw}) * lie::SO3d::exp({roll(bump), 0.01 + pitch(bump), 0});
    return lie::SE3d(R, {at.position.x(), at.position.y(), 1.6 + heave(bump)});
  };
}

void light(Scene& scene, Random& random) {
  const double azimuth = random.uniform(0, 2 * M_PI);
  const double rise = random.uniform(0.5, 1.1);
  scene.lighting.ambient = 0.45F;
  scene.lighting.sun = 0.6F;
  scene.lighting.ambient_reach_m = 4.0F;
  scene.lighting.to_sun = Vector3d(std::cos(azimuth) * std::cos(rise),
                                   std::sin(azimuth) * std::cos(rise), std::sin(rise))
                              .cast<float>();
}

}  // namespace

Scene make_street(TextureBank& bank,
                  Random random,
                  const std::function<double(double)>& travel_time) {
  Block block{};
  block.half_x = random.uniform(50.0, 75.0);
  block.half_y = random.uniform(38.0, 50.0);
  Scene scene;
  scene.sky_texture = scene.paint(bank, Material::kSky, 1.0, random).texture;
  add_ground(scene, block, bank, random);
  const BuildingPaints paints = building_paints(scene, bank, random);
  line_with_buildings(scene, block, paints, random);
  const Vegetation plants = grow_vegetation(scene, bank, random);
  furnish(scene, block, paints, plants, random);
  const std::vector<std::size_t> cars = build_cars(scene, bank, random);
  park(scene, block, cars, random);
  const PlanarLoop own_lane = lane(block, kLane, 9.0);
  if (travel_time) drive(scene, block, own_lane, cars, travel_time, random);
  light(scene, random);
  scene.path = ride(own_lane, random);
  return scene;
}

}  // namespace imslam::simulation
