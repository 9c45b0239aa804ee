#include "datasets/simulation/vegetation.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <utility>

namespace imslam::simulation {
namespace {

using Eigen::Vector3d;

constexpr double kFarShare = 0.18;

struct Leafage {
  Paint paint;
  double length;       ///< [m]
  double slim;         ///< width over length
  double share = 1.0;  ///< of the full number of leaves; fewer ones are larger
};

int leaf_count(const Leafage& leafage, int full) {
  return std::max(3, static_cast<int>(leafage.share * full));
}

void add_leaf_at(Mesh& mesh,
                 const Vector3d& place,
                 const Vector3d& outwards,
                 const Leafage& leafage,
                 Random& random) {
  const Vector3d direction = (outwards.normalized() + 0.8 * random.normal3()).normalized();
  const Vector3d side = direction.cross(random.normal3()).normalized();
  const double length = leafage.length * random.uniform(0.6, 1.4) / std::sqrt(leafage.share);
  Paint paint = leafage.paint;
  const double u = random.uniform();
  const double v = random.uniform();
  paint.offset = Eigen::Vector2d(u, v).cast<float>();
  mesh.add_leaf(place, place + length * direction, 0.5 * leafage.slim * length * side, paint);
}

/// A bough with twigs of leaves along its outer part.
void add_bough(Mesh& mesh,
               const Vector3d& from,
               const Vector3d& to,
               double radius,
               int leaves,
               const Paint& bark,
               const Leafage& leafage,
               Random& random) {
  mesh.add_tube(from, to, radius, 0.25 * radius, 5, bark, 2.0);
  const double spread = 0.1 * (to - from).norm();
  for (int i = 0; i < leaf_count(leafage, leaves); ++i) {
    const double along = 0.3 + 0.75 * std::sqrt(random.uniform());
    const Vector3d off = spread * random.normal3();
    add_leaf_at(mesh, from + along * (to - from) + off, off + 0.3 * (to - from), leafage, random);
  }
}

Mesh broadleaf(const Paint& bark, const Leafage& leafage, Random& random) {
  Mesh mesh;
  const double height = random.uniform(7.0, 11.0);
  const double radius = random.uniform(0.13, 0.26);
  const double lean_x = random.uniform(-0.06, 0.06);
  const double lean_y = random.uniform(-0.06, 0.06);
  const Vector3d lean(lean_x, lean_y, 1.0);
  mesh.add_tube({0, 0, -0.2}, 0.35 * lean, 1.5 * radius, 1.05 * radius, 14, bark, 0.25);
  mesh.add_tube(0.35 * lean, height * lean, 1.05 * radius, 0.35 * radius, 12, bark, 0.8);
  const int boughs = static_cast<int>(random.integer(11, 15));
  for (int i = 0; i < boughs; ++i) {
    const double z = height * random.uniform(0.42, 0.97);
    const double azimuth = 2.4 * i + random.uniform(-0.4, 0.4);
    const double rise = random.uniform(0.1, 0.8);
    const double length = random.uniform(1.2, 2.8) * (1.2 - 0.6 * z / height);
    const Vector3d direction(std::cos(azimuth), std::sin(azimuth), rise);
    add_bough(mesh, z * lean, z * lean + length * direction.normalized(), 0.045, 95, bark, leafage,
              random);
  }
  return mesh;
}

Mesh conifer(const Paint& bark, const Leafage& leafage, Random& random) {
  Mesh mesh;
  const double height = random.uniform(9.0, 14.0);
  const double radius = random.uniform(0.14, 0.24);
  mesh.add_tube({0, 0, -0.2}, {0, 0, height}, 1.2 * radius, 0.1 * radius, 12, bark, 0.6);
  const int whorls = static_cast<int>(random.integer(9, 13));
  for (int k = 0; k < whorls; ++k) {
    const double share = (k + 1.0) / (whorls + 1.0);
    const double z = height * (0.2 + 0.78 * share);
    const double length = 2.3 * (1.05 - share);
    for (int i = 0; i < 5; ++i) {
      const double azimuth = 2 * M_PI * (i + 0.37 * k) / 5 + random.uniform(-0.2, 0.2);
      const Vector3d direction(std::cos(azimuth), std::sin(azimuth), -0.25);
      add_bough(mesh, {0, 0, z}, Vector3d(0, 0, z) + length * direction, 0.03, 22, bark, leafage,
                random);
    }
  }
  return mesh;
}

Mesh bush(const Leafage& leafage, Random& random) {
  Mesh mesh;
  for (int i = 0; i < leaf_count(leafage, 750); ++i) {
    Vector3d place = random.normal3();
    place *= std::pow(random.uniform(), 0.4) / place.norm();
    place.z() = 0.55 + 0.55 * place.z();
    add_leaf_at(mesh, place, place, leafage, random);
  }
  return mesh;
}

Mesh fern(const Leafage& leafage, Random& random) {
  Mesh mesh;
  const int fronds = static_cast<int>(random.integer(7, 12));
  for (int i = 0; i < fronds; ++i) {
    const double azimuth = 2 * M_PI * i / fronds + random.uniform(-0.3, 0.3);
    const double length = random.uniform(0.3, 0.6);
    const Vector3d out(std::cos(azimuth), std::sin(azimuth), 0.0);
    const Vector3d across(-out.y(), out.x(), 0.0);
    for (int k = 1; k <= 7; ++k) {
      const double s = k / 7.0;
      const Vector3d place = length * s * out + Vector3d(0, 0, length * 1.3 * s * (1.15 - s));
      for (const double side : {-1.0, 1.0}) {
        const Vector3d tip = place + 0.3 * length * (1.05 - s) * (side * across + 0.3 * out);
        Paint paint = leafage.paint;
        paint.offset = Eigen::Vector2f(0.1F * static_cast<float>(i), 0.13F * static_cast<float>(k));
        mesh.add_leaf(place, tip, 0.03 * out, paint);
      }
    }
  }
  return mesh;
}

Mesh stone(const Paint& rock, Random& random) {
  Mesh mesh;
  const double x = random.uniform(0.25, 0.6);
  const double y = random.uniform(0.25, 0.6);
  const double z = random.uniform(0.2, 0.5);
  mesh.add_blob({0, 0, 0.3 * z}, {x, y, z}, 0.16, random, rock);
  return mesh;
}

Mesh fallen_log(const Paint& bark, Random& random) {
  Mesh mesh;
  const double half = random.uniform(1.0, 1.7);
  const double radius = random.uniform(0.13, 0.22);
  mesh.add_tube({-half, 0, radius}, {half, 0, 0.9 * radius}, radius, 0.8 * radius, 14, bark, 0.4);
  mesh.add_tube({0.2, 0, radius}, {0.6, 0.3, 0.8}, 0.05, 0.02, 6, bark, 0.4);
  return mesh;
}

}  // namespace

Vegetation grow_vegetation(Scene& scene, TextureBank& bank, Random& random) {
  Vegetation plants;
  const auto add = [&](std::vector<std::size_t>& list, Mesh mesh) {
    scene.prototypes.push_back(std::move(mesh));
    list.push_back(scene.prototypes.size() - 1);
  };
  std::vector<Paint> barks;
  std::vector<Paint> leaves;
  for (int i = 0; i < 3; ++i) {
    barks.push_back(scene.paint(bank, Material::kBark, 0.9, random));
    leaves.push_back(scene.paint(bank, Material::kLeaf, 1.0, random));
  }
  const Paint rock = scene.paint(bank, Material::kRock, 0.9, random);
  for (std::size_t i = 0; i < 3; ++i) {
    add(plants.broadleaves, broadleaf(barks[i], {leaves[i], 0.2, 0.55}, random));
    add(plants.conifers, conifer(barks[2 - i], {leaves[2 - i], 0.34, 0.3}, random));
    add(plants.far_broadleaves, broadleaf(barks[i], {leaves[i], 0.2, 0.65, kFarShare}, random));
    add(plants.far_conifers, conifer(barks[2 - i], {leaves[2 - i], 0.34, 0.4, kFarShare}, random));
    add(plants.bushes, bush({leaves[i], 0.17, 0.5}, random));
    add(plants.far_bushes, bush({leaves[i], 0.17, 0.6, kFarShare}, random));
    add(plants.ferns, fern({leaves[i], 0.2, 0.3}, random));
    add(plants.stones, stone(rock, random));
    add(plants.logs, fallen_log(barks[i], random));
  }
  return plants;
}

}  // namespace imslam::simulation
