#include <cmath>

#include "datasets/simulation/furniture.hpp"
#include "datasets/simulation/paths.hpp"
#include "datasets/simulation/scene.hpp"

namespace imslam::simulation {
namespace {

using Eigen::Vector3d;

/// Inner size of the room; it is centred on the origin.
struct RoomShape {
  double length;  ///< x [m]
  double width;   ///< y [m]
  double height;  ///< z [m]
};

/// Where along the walls things may stand: four walls, seen from the room.
struct Wall {
  lie::SE3d pose;  ///< x out of the wall, z up, origin at the foot of its middle
  double length;
};

std::vector<Wall> walls_of(const RoomShape& room) {
  return {{upright(-0.5 * room.length, 0, 0, 0.0), room.width},
          {upright(0.5 * room.length, 0, 0, M_PI), room.width},
          {upright(0, -0.5 * room.width, 0, M_PI / 2), room.length},
          {upright(0, 0.5 * room.width, 0, -M_PI / 2), room.length}};
}

void add_shell(Scene& scene, const RoomShape& room, TextureBank& bank, Random& random) {
  const Material floors[] = {Material::kPlanks, Material::kCarpet, Material::kTiles};
  const Material sides[] = {Material::kPlaster, Material::kBrick, Material::kConcrete};
  const Vector3d x(room.length, 0, 0);
  const Vector3d y(0, room.width, 0);
  const Vector3d up(0, 0, room.height);
  const Vector3d corner(-0.5 * room.length, -0.5 * room.width, 0);
  scene.fixed.add_quad(corner, x, y, scene.paint(bank, floors[random.integer(0, 2)], 1.8, random),
                       0.2);
  scene.fixed.add_quad(corner + y + up, x, -y, scene.paint(bank, Material::kCeiling, 2.2, random),
                       0.3);
  for (const Wall& wall : walls_of(room)) {
    const Paint paint = scene.paint(bank, sides[random.integer(0, 2)], 2.2, random);
    const lie::SO3d& R = wall.pose.rotation();
    const Vector3d along = R * Vector3d(0, wall.length, 0);
    scene.fixed.add_quad(wall.pose.translation() - 0.5 * along, along, up, paint, 0.2);
    const Paint skirting{paint.texture, 0.7F, paint.offset};
    scene.fixed.add_box(wall.pose * upright(0.01, 0, 0.05, 0), {0.02, wall.length, 0.1}, skirting);
  }
}

void furnish(Scene& scene, const RoomShape& room, const FurniturePaints& paints, Random& random) {
  using Maker = void (*)(Mesh&, const lie::SE3d&, const FurniturePaints&, Random&);
  const Maker makers[] = {add_bookshelf, add_cabinet, add_table, add_sofa, add_boxes, add_plant};
  for (const Wall& wall : walls_of(room)) {
    const double reach = 0.5 * wall.length - 1.2;  // corners stay free: two walls meet there
    for (double y = -reach; y <= reach; y += random.uniform(1.9, 2.3)) {
      if (random.chance(0.85)) {
        const lie::SE3d pose = wall.pose * upright(0.03, y, 0, 0);
        makers[random.integer(0, 5)](scene.fixed, pose, paints, random);
      }
    }
    for (double y = -reach - 0.4; y <= reach + 0.4; y += random.uniform(0.8, 1.5)) {
      const double width = random.uniform(0.35, 0.75);
      const double height = random.uniform(0.35, 0.9);
      const double z = random.uniform(1.7, room.height - 0.55);
      add_picture(scene.fixed, wall.pose * upright(0, y, z, 0), width, height, paints, random);
    }
  }
}

/// A low island in the middle, well under the flight.
void add_island(Scene& scene, const FurniturePaints& paints, Random& random) {
  const double yaw = random.uniform(0, 2 * M_PI);
  add_table(scene.fixed, upright(-0.3, 0, 0, 0) * upright(0, 0, 0, yaw), paints, random);
  for (int i = 0; i < 5; ++i) {
    const double angle = yaw + 2 * M_PI * (i + random.uniform(0.2, 0.8)) / 5;
    const double radius = random.uniform(1.1, 1.5);
    const double h = random.uniform(0.2, 0.5);
    const double size = random.uniform(0.25, 0.45);
    scene.fixed.add_box(upright(radius * std::cos(angle), radius * std::sin(angle), 0.5 * h, angle),
                        {size, size, h}, any(paints.pictures, random));
  }
}

void light(Scene& scene, const RoomShape& room, const FurniturePaints& paints, Random& random) {
  scene.lighting.ambient = 0.3F;
  for (const double x : {-0.25, 0.25}) {
    for (const double y : {-0.25, 0.25}) {
      const double dx = random.uniform(-0.3, 0.3);
      const double dy = random.uniform(-0.3, 0.3);
      const Vector3d lamp(x * room.length + dx, y * room.width + dy, room.height - 0.25);
      const double power = random.uniform(1.2, 2.4);
      scene.lighting.lamps.push_back({lamp.cast<float>(), static_cast<float>(power)});
      scene.fixed.add_box(lie::SE3d(lie::SO3d(), lamp + Vector3d(0, 0, 0.2)), {0.6, 0.3, 0.06},
                          any(paints.metal, random), true);
    }
  }
}

/// Circles around the island, rising and sinking, the gaze wandering between along and outwards.
std::function<lie::SE3d(double)> flight(const RoomShape& room, Random& random) {
  const double a = 0.5 * room.length - 1.55;
  const double b = 0.5 * room.width - 1.55;
  const double turn = random.chance(0.5) ? 1.0 : -1.0;
  const double phase = random.uniform(0, 2 * M_PI);
  const double rate = turn * random.uniform(0.30, 0.38);
  const Wobble shrink(random, 0.16, 0.03, 0.12);
  const Wobble height(random, 0.42, 0.05, 0.25);
  const Wobble gaze(random, 0.8, 0.03, 0.15);
  const Wobble pitch(random, 0.22, 0.08, 0.5);
  const Wobble roll(random, 0.16, 0.1, 0.6);
  const Wobble shake(random, 0.02, 0.8, 2.0);
  return [=](double t) {
    const double angle = phase + rate * t;
    const double size = 0.84 + shrink(t);
    const Vector3d position(size * a * std::cos(angle), size * b * std::sin(angle),
                            1.42 + height(t));
    const double yaw = angle + turn * (M_PI / 2 - 0.35) + gaze(t) + shake(1.3 * t);
    const lie::SO3d R = lie::SO3d::exp({0, 0, yaw}) * lie::SO3d::exp({0, 0.08 + pitch(t), 0}) *
                        lie::SO3d::exp({roll(t) + shake(t), 0, 0});
    return lie::SE3d(R, position);
  };
}

}  // namespace

Scene make_room(TextureBank& bank, Random random) {
  const double length = random.uniform(7.0, 9.5);
  const double width = random.uniform(6.2, 8.0);
  const double height = random.uniform(2.8, 3.4);
  const RoomShape room{length, width, height};
  Scene scene;
  add_shell(scene, room, bank, random);
  const FurniturePaints paints = furniture_paints(scene, bank, random);
  furnish(scene, room, paints, random);
  add_island(scene, paints, random);
  light(scene, room, paints, random);
  scene.sky_texture = 0;
  scene.path = flight(room, random);
  return scene;
}

}  // namespace imslam::simulation
