#include "datasets/simulation/vehicle.hpp"

#include <algorithm>
#include <utility>

namespace imslam::simulation {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;

struct CarPaints {
  Paint body;
  Paint glass;
  Paint tyre;
  Paint plate;
};

/// A side view (x, z) from back to front, drawn out to a width that may change along it.
struct Profile {
  std::vector<Vector2d> line;
  std::vector<double> half_widths;
};

Vector3d corner(const Profile& profile, std::size_t i, double side, double z) {
  return {profile.line[i].x(), side * profile.half_widths[i], z};
}

/// Top strip and both sides down to `bottom`; `glassy` pieces get the glass.
void draw_out(Mesh& mesh,
              const Profile& profile,
              double bottom,
              const std::vector<bool>& glassy,
              const Paint& sides,
              const CarPaints& paints) {
  for (std::size_t i = 0; i + 1 < profile.line.size(); ++i) {
    const double z0 = profile.line[i].y();
    const double z1 = profile.line[i + 1].y();
    mesh.add_patch(corner(profile, i, -1, z0), corner(profile, i + 1, -1, z1),
                   corner(profile, i + 1, 1, z1), corner(profile, i, 1, z0),
                   glassy[i] ? paints.glass : paints.body);
    mesh.add_patch(corner(profile, i, -1, bottom), corner(profile, i + 1, -1, bottom),
                   corner(profile, i + 1, -1, z1), corner(profile, i, -1, z0), sides);
    mesh.add_patch(corner(profile, i + 1, 1, bottom), corner(profile, i, 1, bottom),
                   corner(profile, i, 1, z0), corner(profile, i + 1, 1, z1), sides);
  }
}

void add_wheels(Mesh& mesh, double front, double back, const CarPaints& paints) {
  constexpr double kRadius = 0.31;
  for (const double x : {front, back}) {
    for (const double side : {-1.0, 1.0}) {
      const Vector3d inner(x, side * 0.62, kRadius);
      const Vector3d outer(x, side * 0.86, kRadius);
      mesh.add_tube(inner, outer, kRadius, kRadius, 16, paints.tyre);
      mesh.add_tube(outer, outer + Vector3d(0, side * 0.01, 0), kRadius, 0.2, 16, paints.tyre);
      mesh.add_tube(outer + Vector3d(0, side * 0.012, 0), outer + Vector3d(0, side * 0.03, 0), 0.2,
                    0.02, 10, paints.plate);
    }
  }
}

Mesh car(const CarPaints& paints, Random& random) {
  const double tail = -random.uniform(1.85, 2.1);
  const double nose = random.uniform(1.9, 2.1);
  const double roof = random.uniform(1.38, 1.65);
  const double rear_window = random.uniform(-1.75, -1.0);
  const bool wagon = random.chance(0.4);
  Mesh mesh;
  const Profile body{{{tail - 0.02, 0.4},
                      {tail, 0.86},
                      {-1.0, 0.93},
                      {0.9, 0.92},
                      {nose - 0.15, 0.74},
                      {nose, 0.4}},
                     {0.84, 0.86, 0.88, 0.88, 0.84, 0.8}};
  draw_out(mesh, body, 0.24, std::vector<bool>(5, false), paints.body, paints);
  const double back = wagon ? tail + 0.15 : rear_window - 0.35;
  const Profile cabin{{{back, 0.9},
                       {wagon ? tail + 0.3 : rear_window + 0.3, roof - 0.03},
                       {0.15, roof},
                       {0.95, 0.9}},
                      {0.78, 0.68, 0.68, 0.78}};
  draw_out(mesh, cabin, 0.88, {true, false, true}, paints.glass, paints);
  add_wheels(mesh, nose - 0.75, tail + 0.72, paints);
  const lie::SE3d front = upright(nose - 0.02, 0, 0.45, 0);
  const lie::SE3d rear = upright(tail - 0.02, 0, 0.6, 0);
  for (const lie::SE3d& end : {front, rear}) {
    mesh.add_box(end, {0.05, 0.5, 0.11}, paints.plate, true);
    for (const double side : {-0.62, 0.62}) {
      mesh.add_box(end * upright(0, side, 0.1, 0), {0.06, 0.26, 0.14}, paints.plate, true);
    }
  }
  // What lies in the car's own shade moves with it.
  mesh.add_quad({tail, -0.82, 0.03}, {nose - tail, 0, 0}, {0, 1.64, 0}, paints.tyre, 4.0);
  return mesh;
}

}  // namespace

std::vector<std::size_t> build_cars(Scene& scene, TextureBank& bank, Random& random) {
  std::vector<std::size_t> cars;
  const Paint tyre = scene.paint(bank, Material::kAsphalt, 0.0, random);
  for (int i = 0; i < 6; ++i) {
    CarPaints paints;
    paints.body = scene.paint(bank, Material::kCar, 0.0, random);
    paints.glass = scene.paint(bank, Material::kGlass, 0.0, random);
    paints.plate = scene.paint(bank, Material::kSign, 0.0, random);
    paints.tyre = tyre;
    scene.prototypes.push_back(car(paints, random));
    cars.push_back(scene.prototypes.size() - 1);
  }
  return cars;
}

}  // namespace imslam::simulation
