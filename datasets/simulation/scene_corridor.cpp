#include <algorithm>
#include <cmath>

#include "datasets/simulation/furniture.hpp"
#include "datasets/simulation/paths.hpp"
#include "datasets/simulation/scene.hpp"

namespace imslam::simulation {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;

/// An L: one leg from the origin along +x to the bend, one from the bend along +y. Walls stand
/// half_width off the centre lines.
struct Bend {
  double first;       ///< length of the leg along x, to the centre of the bend [m]
  double second;      ///< length of the leg along y [m]
  double half_width;  ///< [m]
  double height;      ///< [m]
};

/// A straight piece of wall: from a to b with the corridor on its left.
struct Side {
  Vector2d a;
  Vector2d b;

  double length() const { return (b - a).norm(); }
  /// Origin at distance s from a, x into the corridor, y from b to a... z up.
  lie::SE3d at(double s, double z) const {
    const Vector2d along = (b - a) / length();
    const Vector2d place = a + s * along;
    return upright(place.x(), place.y(), z, std::atan2(along.x(), -along.y()));
  }
};

std::vector<Side> sides_of(const Bend& l) {
  const double w = l.half_width;
  const Vector2d start_right(-w, -w);
  const Vector2d outer(l.first + w, -w);
  const Vector2d end_right(l.first + w, l.second + w);
  const Vector2d end_left(l.first - w, l.second + w);
  const Vector2d inner(l.first - w, w);
  const Vector2d start_left(-w, w);
  return {{start_right, outer}, {outer, end_right},  {end_right, end_left},
          {end_left, inner},    {inner, start_left}, {start_left, start_right}};
}

void add_shell(Scene& scene, const Bend& l, TextureBank& bank, Random& random) {
  const double w = l.half_width;
  const Material floors[] = {Material::kTiles, Material::kCarpet, Material::kConcrete};
  const Paint floor = scene.paint(bank, floors[random.integer(0, 2)], 1.5, random);
  const Paint ceiling = scene.paint(bank, Material::kCeiling, 2.4, random);
  const Vector3d first(l.first + 2 * w, 0, 0);
  const Vector3d across(0, 2 * w, 0);
  const Vector3d up(0, 0, l.height);
  const Vector3d corner(-w, -w, 0);
  const Vector3d elbow(l.first - w, w, 0);
  const Vector3d wide(2 * w, 0, 0);
  const Vector3d second(0, l.second, 0);
  scene.fixed.add_quad(corner, first, across, floor);
  scene.fixed.add_quad(elbow, wide, second, floor);
  scene.fixed.add_quad(corner + across + up, first, -across, ceiling);
  scene.fixed.add_quad(elbow + second + up, wide, -second, ceiling);
  const Material walls[] = {Material::kPlaster, Material::kBrick, Material::kConcrete};
  const Paint paints[] = {scene.paint(bank, walls[random.integer(0, 2)], 2.0, random),
                          scene.paint(bank, Material::kPlaster, 1.7, random)};
  int count = 0;
  for (const Side& side : sides_of(l)) {
    const Vector2d along = side.b - side.a;
    scene.fixed.add_quad({side.a.x(), side.a.y(), 0}, {along.x(), along.y(), 0}, up,
                         paints[count++ % 2]);
  }
}

struct CorridorPaints {
  FurniturePaints furniture;
  std::vector<Paint> doors;
  std::vector<Paint> signs;
  Paint pipe;
};

void add_door(
    Mesh& mesh, const Side& side, double s, const CorridorPaints& paints, Random& random) {
  constexpr double kWidth = 0.95;
  constexpr double kHeight = 2.05;
  const Paint& frame = any(paints.furniture.metal, random);
  const lie::SE3d pose = side.at(s, 0.0);
  for (const double y : {-0.5, 0.5}) {
    mesh.add_box(pose * upright(0.03, y * (kWidth + 0.1), 0.5 * kHeight, 0), {0.1, 0.1, kHeight},
                 frame);
  }
  mesh.add_box(pose * upright(0.03, 0, kHeight + 0.05, 0), {0.1, kWidth + 0.2, 0.1}, frame, true);
  const lie::SE3d leaf = pose * upright(0.012, 0, 0.5 * kHeight, 0);
  mesh.add_box(leaf, {0.02, kWidth, kHeight}, any(paints.doors, random));
  mesh.add_box(pose * upright(0.02, kWidth * 0.5 + 0.3, 1.55, 0), {0.02, 0.22, 0.16},
               any(paints.signs, random));
}

/// Doors, pictures, cupboards and columns; nothing reaches further than `reach` into the corridor.
void fit_out(Scene& scene, const Bend& l, const CorridorPaints& paints, Random& random) {
  constexpr double kReach = 0.42;
  for (const Side& side : sides_of(l)) {
    for (double s = 0.9; s < side.length() - 0.8; s += random.uniform(1.3, 2.1)) {
      const double what = random.uniform();
      const lie::SE3d foot = side.at(s, 0.0);
      if (what < 0.35) {
        add_door(scene.fixed, side, s, paints, random);
      } else if (what < 0.75) {
        const double width = random.uniform(0.4, 0.9);
        const double height = random.uniform(0.4, 0.9);
        const double z = random.uniform(1.2, 1.75);
        add_picture(scene.fixed, side.at(s, z), width, height, paints.furniture, random);
      } else if (what < 0.86) {
        const double tall = random.uniform(0.8, 1.9);
        const double width = random.uniform(0.4, 0.9);
        scene.fixed.add_box(foot * upright(0.5 * kReach, 0, 0.5 * tall, 0), {kReach, width, tall},
                            any(paints.furniture.metal, random));
      } else if (what < 0.93) {
        add_boxes(scene.fixed, foot * upright(-0.15, 0, 0, 0), paints.furniture, random);
      } else {
        scene.fixed.add_box(foot * upright(0.1, 0, 0.5 * l.height, 0), {0.2, 0.35, l.height},
                            any(paints.furniture.cloth, random));
      }
    }
  }
}

/// Lamps, pipes and a few hanging signs under the ceiling.
void hang(Scene& scene, const Bend& l, const CorridorPaints& paints, Random& random) {
  scene.lighting.ambient = 0.28F;
  const double top = l.height;
  const auto lamp_at = [&](double x, double y) {
    const Vector3d lamp(x, y, top - 0.12);
    const double power = random.uniform(0.5, 1.3);
    scene.lighting.lamps.push_back({lamp.cast<float>(), static_cast<float>(power)});
    scene.fixed.add_box(upright(x, y, top - 0.03, 0), {0.5, 0.22, 0.05}, any(paints.signs, random),
                        true);
  };
  for (double x = 0.5; x < l.first; x += random.uniform(2.6, 3.8)) lamp_at(x, 0.0);
  for (double y = 0.5; y < l.second; y += random.uniform(2.6, 3.8)) lamp_at(l.first, y);
  const double w = l.half_width - 0.12;
  scene.fixed.add_tube({-l.half_width, w, top - 0.2}, {l.first - w, w, top - 0.2}, 0.05, 0.05, 10,
                       paints.pipe, 0.4);
  scene.fixed.add_tube({-l.half_width, -w, top - 0.3}, {l.first, -w, top - 0.3}, 0.07, 0.07, 10,
                       paints.pipe, 0.4);
  scene.fixed.add_tube({l.first + w, 0, top - 0.25}, {l.first + w, l.second, top - 0.25}, 0.06,
                       0.06, 10, paints.pipe, 0.4);
  for (double x = 4.0; x < l.first - 2.0; x += random.uniform(6.0, 10.0)) {
    scene.fixed.add_box(upright(x, 0.35, top - 0.2, 0), {0.03, 0.7, 0.24},
                        any(paints.signs, random), true);
  }
}

/// There along the right side, back along the other, a turn at each end.
PlanarLoop walk_line(const Bend& l) {
  constexpr double kOff = 0.3;  ///< from the centre line
  std::vector<Vector2d> points = {{0.6, -kOff}, {l.first + kOff, -kOff}};
  points.emplace_back(l.first + kOff, l.second - 0.6);
  add_arc(points, {l.first, l.second - 0.6}, kOff, 0.0, M_PI);
  points.emplace_back(l.first - kOff, kOff);
  add_arc(points, {0.6, 0.0}, kOff, M_PI / 2, 3 * M_PI / 2);
  PlanarLoop::Limits limits;
  limits.speed = 1.3;
  limits.turn_rate = 0.9;
  limits.smoothing_m = 0.7;
  return PlanarLoop(points, limits);
}

std::function<lie::SE3d(double)> walk(const Bend& l, Random& random) {
  const PlanarLoop loop = walk_line(l);
  const Wobble gaze(random, 0.3, 0.04, 0.2);
  const Wobble pitch(random, 0.12, 0.08, 0.5);
  const Wobble roll(random, 0.08, 0.1, 0.6);
  const Wobble height(random, 0.12, 0.04, 0.2);
  const double step_phase = random.uniform(0, 2 * M_PI);
  return [=](double t) {
    const PlanarLoop::Pose at = loop.at_time(t);
    // Each step of about 0.72 m lifts the body; every second one sways it.
    const double step = 2 * M_PI * at.distance / 0.72 + step_phase;
    const Vector3d position(at.position.x(), at.position.y(),
                            1.5 + height(t) + 0.018 * std::sin(step));
    const double sway = 0.02 * std::sin(0.5 * step);
    const lie::SO3d R = lie::SO3d::exp({0, 0, at.yaw + gaze(t) + sway}) *
                        lie::SO3d::exp({0, 0.03 + pitch(t) + 0.012 * std::cos(step), 0}) *
                        lie::SO3d::exp({roll(t) + sway, 0, 0});
    return lie::SE3d(R, position);
  };
}

}  // namespace

Scene make_corridor(TextureBank& bank, Random random) {
  Bend bend{};
  bend.first = random.uniform(14.0, 24.0);
  bend.second = random.uniform(8.0, 16.0);
  bend.half_width = random.uniform(1.15, 1.4);
  bend.height = random.uniform(2.5, 2.9);
  Scene scene;
  add_shell(scene, bend, bank, random);
  CorridorPaints paints;
  paints.furniture = furniture_paints(scene, bank, random);
  for (int i = 0; i < 3; ++i) {
    paints.doors.push_back(scene.paint(bank, Material::kDoor, 0.0, random));
    paints.signs.push_back(scene.paint(bank, Material::kSign, 0.0, random));
  }
  paints.pipe = scene.paint(bank, Material::kMetal, 0.5, random);
  fit_out(scene, bend, paints, random);
  hang(scene, bend, paints, random);
  scene.path = walk(bend, random);
  return scene;
}

}  // namespace imslam::simulation
