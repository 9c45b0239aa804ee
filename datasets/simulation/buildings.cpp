#include "datasets/simulation/buildings.hpp"

#include <algorithm>
#include <cmath>

#include "datasets/simulation/furniture.hpp"

namespace imslam::simulation {
namespace {

using Eigen::Vector3d;

/// A thin panel on a front that looks along -x, its foot at height z.
void add_panel(Mesh& mesh,
               const lie::SE3d& front,
               double y,
               double z,
               double width,
               double height,
               const Paint& paint,
               double thickness = 0.06) {
  mesh.add_box(front * upright(-0.5 * thickness, y, z + 0.5 * height, 0),
               {thickness, width, height}, paint, true, 3.0);
}

void add_ground_floor(Mesh& mesh,
                      const lie::SE3d& front,
                      double width,
                      const BuildingPaints& paints,
                      Random& random) {
  for (double y = -0.5 * width + 1.2; y < 0.5 * width - 1.6; y += random.uniform(2.4, 3.6)) {
    const double what = random.uniform();
    if (what < 0.3) {
      add_panel(mesh, front, y, 0.12, 1.1, 2.2, any(paints.doors, random));
    } else if (what < 0.75) {
      const double wide = random.uniform(1.5, 2.2);
      add_panel(mesh, front, y + 0.2, 0.6, wide, 1.9, any(paints.windows, random));
      if (random.chance(0.6)) {
        add_panel(mesh, front, y + 0.2, 2.65, wide, 0.5, any(paints.signs, random), 0.15);
      }
    } else {
      mesh.add_box(front * upright(-0.6, y, 2.7, 0), {1.2, 1.9, 0.12}, any(paints.signs, random),
                   true);
    }
  }
}

void add_balconies(Mesh& mesh,
                   const lie::SE3d& front,
                   double width,
                   double height,
                   const BuildingPaints& paints,
                   Random& random) {
  const Paint& rail = any(paints.metal, random);
  for (double z = 4.0; z < height - 2.0; z += 3.1) {
    for (double y = -0.5 * width + 1.5; y < 0.5 * width - 1.4; y += 3.4) {
      if (random.chance(0.3)) continue;
      mesh.add_box(front * upright(-0.45, y, z + 0.45, 0), {0.9, 2.0, 0.9}, rail, true, 2.0);
    }
  }
}

}  // namespace

BuildingPaints building_paints(Scene& scene, TextureBank& bank, Random& random) {
  BuildingPaints paints;
  const auto draw = [&](std::vector<Paint>& list, Material material, double tile_m, int count) {
    for (int i = 0; i < count; ++i) list.push_back(scene.paint(bank, material, tile_m, random));
  };
  draw(paints.facades, Material::kFacade, 8.0, 8);
  draw(paints.walls, Material::kBrick, 3.0, 2);
  draw(paints.walls, Material::kConcrete, 4.0, 2);
  draw(paints.doors, Material::kDoor, 0.0, 3);
  draw(paints.windows, Material::kPoster, 0.0, 6);
  draw(paints.signs, Material::kSign, 0.0, 5);
  draw(paints.metal, Material::kMetal, 1.2, 2);
  return paints;
}

void add_building(
    Mesh& mesh, const lie::SE3d& pose, double width, const BuildingPaints& paints, Random& random) {
  const double depth = random.uniform(9.0, 12.0);
  const double height = random.uniform(7.0, 17.0);
  // pose looks along -x: the body of the house lies at +x behind its front.
  mesh.add_box(pose * upright(0.5 * depth, 0, 0.5 * height, 0), {depth, width, height},
               any(paints.facades, random), false, 2.5);
  const Paint& trim = any(paints.walls, random);
  mesh.add_box(pose * upright(0.5 * depth, 0, height + 0.15, 0), {depth + 0.6, width + 0.1, 0.3},
               trim, true, 3.0);
  mesh.add_box(pose * upright(-0.05, 0, 3.35, 0), {0.2, width, 0.25}, trim, true, 3.0);
  if (random.chance(0.5)) {
    const double attic = random.uniform(1.5, 3.0);
    mesh.add_box(pose * upright(0.5 * depth + 1.0, 0, height + 0.3 + 0.5 * attic, 0),
                 {depth - 2.0, 0.7 * width, attic}, any(paints.walls, random), false, 3.0);
  }
  add_ground_floor(mesh, pose, width, paints, random);
  if (random.chance(0.4)) add_balconies(mesh, pose, width, height, paints, random);
}

void add_skyline(Mesh& mesh, double radius, const BuildingPaints& paints, Random& random) {
  const int count = 22;
  for (int i = 0; i < count; ++i) {
    const double angle = 2 * M_PI * (i + random.uniform(-0.2, 0.2)) / count;
    const double distance = radius * random.uniform(1.0, 1.25);
    const double height = random.uniform(12.0, 38.0);
    const double width = random.uniform(16.0, 30.0);
    mesh.add_box(
        upright(distance * std::cos(angle), distance * std::sin(angle), 0.5 * height, angle),
        {14.0, width, height}, any(paints.facades, random), false, 8.0);
  }
}

void add_street_furniture(Mesh& mesh,
                          const lie::SE3d& pose,
                          const BuildingPaints& paints,
                          Random& random) {
  const Paint& metal = any(paints.metal, random);
  const double what = random.uniform();
  const Vector3d foot = pose * Vector3d(0, 0, -0.1);
  if (what < 0.35) {
    const Vector3d top = pose * Vector3d(0, 0, 5.2);
    mesh.add_tube(foot, top, 0.08, 0.05, 10, metal);
    mesh.add_tube(top, pose * Vector3d(-0.9, 0, 5.35), 0.04, 0.04, 6, metal);
    mesh.add_box(pose * upright(-1.1, 0, 5.35, 0), {0.5, 0.2, 0.12}, metal, true);
  } else if (what < 0.65) {
    mesh.add_tube(foot, pose * Vector3d(0, 0, 2.6), 0.035, 0.035, 8, metal);
    mesh.add_box(pose * upright(0, 0.03, 2.25, M_PI / 2), {0.03, 0.6, 0.6},
                 any(paints.signs, random), true);
  } else if (what < 0.85) {
    mesh.add_box(pose * upright(0, 0, 0.45, 0), {0.45, 0.5, 0.9}, any(paints.signs, random));
  } else {
    const double height = random.uniform(1.6, 2.4);
    mesh.add_box(pose * upright(0.15, 0, 0.5 * height, 0), {0.3, 0.9, height},
                 any(paints.windows, random));
  }
}

}  // namespace imslam::simulation
