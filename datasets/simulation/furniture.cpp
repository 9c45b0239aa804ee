#include "datasets/simulation/furniture.hpp"

#include <cmath>

namespace imslam::simulation {
namespace {

using Eigen::Vector3d;

lie::SE3d at(const lie::SE3d& pose, double x, double y, double z, double yaw = 0.0) {
  return pose * upright(x, y, z, yaw);
}

void add_faced_box(Mesh& mesh,
                   const lie::SE3d& pose,
                   const Vector3d& size,
                   const Paint& body,
                   const Paint& front) {
  mesh.add_box(pose, size, body);
  const Vector3d half = 0.5 * size;
  const lie::SO3d& R = pose.rotation();
  mesh.add_quad(pose * Vector3d(half.x() + 0.004, -half.y() + 0.02, -half.z() + 0.02),
                R * Vector3d(0, size.y() - 0.04, 0), R * Vector3d(0, 0, size.z() - 0.04), front);
}

/// Small things on a horizontal place of the given extent.
void add_clutter(Mesh& mesh,
                 const lie::SE3d& pose,
                 double depth,
                 double width,
                 int count,
                 const FurniturePaints& paints,
                 Random& random) {
  for (int i = 0; i < count; ++i) {
    const double x = random.uniform(-0.38, 0.38) * depth;
    const double y = random.uniform(-0.42, 0.42) * width;
    const double yaw = random.uniform(-1.5, 1.5);
    if (random.chance(0.6)) {
      const double a = random.uniform(0.08, 0.25);
      const double b = random.uniform(0.08, 0.2);
      const double h = random.uniform(0.04, 0.3);
      mesh.add_box(at(pose, x, y, 0.5 * h, yaw), {a, b, h}, any(paints.pictures, random));
    } else {
      const double h = random.uniform(0.1, 0.3);
      const double r = random.uniform(0.03, 0.08);
      const Vector3d foot = pose * Vector3d(x, y, 0.0);
      const Vector3d top = pose * Vector3d(x, y, h);
      const double r_top = r * random.uniform(0.6, 1.3);
      mesh.add_tube(foot, top, r, r_top, 12, any(paints.cloth, random), 0.2);
    }
  }
}

}  // namespace

const Paint& any(const std::vector<Paint>& paints, Random& random) {
  return paints[static_cast<std::size_t>(
      random.integer(0, static_cast<std::int64_t>(paints.size()) - 1))];
}

FurniturePaints furniture_paints(Scene& scene, TextureBank& bank, Random& random) {
  FurniturePaints paints;
  const auto draw = [&](std::vector<Paint>& list, Material material, double tile_m, int count) {
    for (int i = 0; i < count; ++i) list.push_back(scene.paint(bank, material, tile_m, random));
  };
  draw(paints.wood, Material::kPlanks, 1.1, 3);
  draw(paints.cloth, Material::kFabric, 0.9, 4);
  draw(paints.metal, Material::kMetal, 1.0, 2);
  draw(paints.pictures, Material::kPoster, 0.0, 9);
  draw(paints.books, Material::kBooks, 0.0, 3);
  draw(paints.leaves, Material::kLeaf, 1.0, 1);
  return paints;
}

void add_bookshelf(Mesh& mesh,
                   const lie::SE3d& pose,
                   const FurniturePaints& paints,
                   Random& random) {
  const double height = random.uniform(1.6, 2.3);
  const double width = random.uniform(0.9, 1.6);
  const Paint& wood = any(paints.wood, random);
  add_faced_box(mesh, at(pose, 0.18, 0, 0.5 * height), {0.34, width, height}, wood,
                any(paints.books, random));
  add_clutter(mesh, at(pose, 0.18, 0, height), 0.3, width, 3, paints, random);
}

void add_cabinet(Mesh& mesh, const lie::SE3d& pose, const FurniturePaints& paints, Random& random) {
  const double height = random.uniform(0.7, 1.3);
  const double width = random.uniform(0.8, 1.6);
  const Paint& wood = any(paints.wood, random);
  add_faced_box(mesh, at(pose, 0.24, 0, 0.5 * height), {0.45, width, height}, wood,
                any(paints.metal, random));
  add_clutter(mesh, at(pose, 0.24, 0, height), 0.4, width, 6, paints, random);
}

void add_table(Mesh& mesh, const lie::SE3d& pose, const FurniturePaints& paints, Random& random) {
  const double depth = random.uniform(0.6, 0.75);
  const double width = random.uniform(1.1, 1.7);
  const double height = random.uniform(0.68, 0.76);
  const Paint& wood = any(paints.wood, random);
  const lie::SE3d middle = at(pose, 0.5 * depth + 0.02, 0, 0);
  mesh.add_box(at(middle, 0, 0, height - 0.02), {depth, width, 0.04}, wood, true);
  for (const double x : {-0.45, 0.45}) {
    for (const double y : {-0.46, 0.46}) {
      mesh.add_box(at(middle, x * depth, y * width, 0.5 * height - 0.02),
                   {0.05, 0.05, height - 0.04}, wood);
    }
  }
  add_clutter(mesh, at(middle, 0, 0, height), depth, width, 8, paints, random);
  add_clutter(mesh, middle, depth, width, 2, paints, random);
}

void add_sofa(Mesh& mesh, const lie::SE3d& pose, const FurniturePaints& paints, Random& random) {
  const double width = random.uniform(1.4, 2.0);
  const Paint& cloth = any(paints.cloth, random);
  mesh.add_box(at(pose, 0.4, 0, 0.22), {0.76, width, 0.44}, cloth);
  mesh.add_box(at(pose, 0.12, 0, 0.65), {0.22, width, 0.42}, cloth);
  for (const double side : {-0.5, 0.5}) {
    mesh.add_box(at(pose, 0.4, side * (width - 0.18), 0.52), {0.76, 0.17, 0.16}, cloth);
  }
  for (int i = 0; i < 3; ++i) {
    const double y = random.uniform(-0.3, 0.3) * width;
    const double yaw = random.uniform(-0.5, 0.5);
    mesh.add_box(at(pose, 0.32, y, 0.6, yaw), {0.12, 0.38, 0.32}, any(paints.pictures, random));
  }
}

void add_boxes(Mesh& mesh, const lie::SE3d& pose, const FurniturePaints& paints, Random& random) {
  double z = 0.0;
  for (int level = 0; level < 3; ++level) {
    const double height = random.uniform(0.25, 0.45);
    const double side = random.uniform(0.4, 0.58);
    const double yaw = random.uniform(-0.25, 0.25);
    const double y = random.uniform(-0.05, 0.05);
    mesh.add_box(at(pose, 0.4, y, z + 0.5 * height, yaw), {side, side, height},
                 any(paints.pictures, random));
    z += height;
    if (random.chance(0.3)) return;
  }
}

void add_plant(Mesh& mesh, const lie::SE3d& pose, const FurniturePaints& paints, Random& random) {
  const Vector3d foot = pose * Vector3d(0.35, 0, 0);
  const Vector3d up(0, 0, 1);
  mesh.add_tube(foot, foot + 0.35 * up, 0.14, 0.18, 14, any(paints.cloth, random), 0.2);
  const double height = random.uniform(0.7, 1.4);
  mesh.add_tube(foot, foot + height * up, 0.02, 0.012, 6, any(paints.wood, random), 0.5);
  for (int i = 0; i < 90; ++i) {
    const double azimuth = random.uniform(0, 2 * M_PI);
    const double rise = random.uniform(-0.5, 0.9);
    const Vector3d out(std::cos(azimuth), std::sin(azimuth), rise);
    const Vector3d root = foot + random.uniform(0.35, 1.0) * height * up + 0.05 * out;
    const Vector3d tip = root + random.uniform(0.12, 0.26) * out.normalized();
    const Vector3d side = random.uniform(0.025, 0.05) * out.cross(up).normalized();
    Paint paint = any(paints.leaves, random);
    const double u = random.uniform();
    const double v = random.uniform();
    paint.offset = Eigen::Vector2d(u, v).cast<float>();
    mesh.add_leaf(root, tip, side, paint);
  }
}

void add_picture(Mesh& mesh,
                 const lie::SE3d& pose,
                 double width,
                 double height,
                 const FurniturePaints& paints,
                 Random& random) {
  const Paint& frame = any(paints.wood, random);
  add_faced_box(mesh, at(pose, 0.015, 0, 0), {0.03, width, height}, frame,
                any(paints.pictures, random));
}

}  // namespace imslam::simulation
