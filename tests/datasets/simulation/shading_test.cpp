#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include "datasets/simulation/ray_table.hpp"
#include "datasets/simulation/rig.hpp"
#include "datasets/simulation/world.hpp"
#include "tests/datasets/simulation/reference_shading.hpp"

namespace imslam::simulation {
namespace {

constexpr const char* kScenes[] = {"room", "corridor", "forest", "street"};

/// A scene family, and a small camera somewhere on its path.
struct Setting {
  explicit Setting(const std::string& scene)
      : options(of(scene)),
        world(make_scene(options, bank, Random(5)), Random(6)),
        rig(make_rig(options.camera, Random(7))),
        rays(rig.left),
        T_world_camera(world.scene().path(4.0) * rig.T_body_left) {}

  static SimulationOptions of(const std::string& scene) {
    SimulationOptions options;
    options.scene = scene;
    options.textures = "procedural";
    options.camera.width = 128;
    return options;
  }

  RayPacket packet(int tile_row, int tile_column) const {
    return rays.tile_packet(T_world_camera.rotation().matrix().cast<float>(), tile_row,
                            tile_column);
  }
  Eigen::Vector3f origin() const { return T_world_camera.translation().cast<float>(); }

  SimulationOptions options;
  TextureBank bank{"procedural"};
  World world;
  StereoRig rig;
  RayTable rays;
  lie::SE3d T_world_camera;
};

Eigen::Vector3d lane_of(const Floats3& lanes, std::size_t i) {
  return Eigen::Vector3f(lanes.x[i], lanes.y[i], lanes.z[i]).cast<double>();
}

ReferenceRay ray_of(const Setting& setting, const RayPacket& packet, std::size_t i) {
  return {setting.origin().cast<double>(), lane_of(packet.direction, i),
          lane_of(packet.d_column, i), lane_of(packet.d_row, i)};
}

double quantile(std::vector<double> values, double share) {
  std::sort(values.begin(), values.end());
  return values[static_cast<std::size_t>(share * static_cast<double>(values.size() - 1))];
}

// All rays of every third tile. The reference is exact where the lanes take a quick logarithm and
// floats, so a rare ray may get a tap or, where levels are rounded, a level more or less.
TEST(Shading, LanesMatchTheSlowReferenceInEveryScene) {
  for (const char* scene : kScenes) {
    const Setting setting(scene);
    const ReferenceShading reference(setting.world.scene());
    for (const float footprint : {1.0F, 0.5F}) {
      std::vector<double> errors;
      for (int tile = 0; tile < setting.rays.tile_rows() * setting.rays.tile_columns(); tile += 3) {
        const RayPacket packet =
            setting.packet(tile / setting.rays.tile_columns(), tile % setting.rays.tile_columns());
        std::array<Hit, kLanes> hits;
        setting.world.closest(setting.origin(), packet, true, hits.data());
        SeenPacket seen;
        setting.world.look(setting.origin(), packet, hits.data(), footprint, seen);
        for (std::size_t i = 0; i < kLanes; ++i) {
          const ReferenceLook look =
              reference.look(ray_of(setting, packet, i), hits[i], static_cast<double>(footprint));
          if (hits[i].empty())
            ASSERT_TRUE(std::isinf(seen.distance[i]));
          else
            ASSERT_NEAR(seen.distance[i], look.distance, 1e-3 * look.distance) << scene;
          errors.push_back(std::abs(static_cast<double>(seen.radiance[i]) - look.radiance));
        }
      }
      EXPECT_LT(quantile(errors, 0.5), 1e-4) << scene << " " << footprint;
      EXPECT_LT(quantile(errors, 0.999), 1e-3) << scene << " " << footprint;
    }
  }
}

/// Nearest distance over all triangles, one after the other; infinity without any.
double nearest_of_all(const Scene& scene, const ReferenceRay& ray) {
  double nearest = std::numeric_limits<double>::infinity();
  for (std::uint32_t instance = 0; instance <= scene.instances.size(); ++instance) {
    const Instance* placed = instance == 0 ? nullptr : &scene.instances[instance - 1];
    const Mesh& mesh = placed == nullptr ? scene.fixed : scene.prototypes[placed->prototype];
    const lie::SE3d T_object_world =
        placed == nullptr ? lie::SE3d() : placed->T_world_object.inverse();
    const double scale = placed == nullptr ? 1.0 : placed->scale;
    const Eigen::Vector3d from = T_object_world * ray.origin / scale;
    const Eigen::Vector3d d = T_object_world.rotation() * ray.direction;
    for (const Triangle& triangle : mesh.triangles) {
      // Moeller and Trumbore, "Fast, Minimum Storage Ray/Triangle Intersection", 1997.
      const Eigen::Vector3d a = mesh.vertices[triangle.a].position.cast<double>();
      const Eigen::Vector3d e1 = mesh.vertices[triangle.b].position.cast<double>() - a;
      const Eigen::Vector3d e2 = mesh.vertices[triangle.c].position.cast<double>() - a;
      const Eigen::Vector3d p = d.cross(e2);
      const double determinant = e1.dot(p);
      const Eigen::Vector3d s = (from - a) / determinant;
      const double u = s.dot(p);
      const Eigen::Vector3d q = s.cross(e1);
      const double v = d.dot(q);
      const double t = scale * e2.dot(q);
      if (u >= 0.0 && v >= 0.0 && u + v <= 1.0 && t > 0.02) nearest = std::min(nearest, t);
    }
  }
  return nearest;
}

TEST(RayTracer, FindsTheNearestOfAllTriangles) {
  for (const char* scene : kScenes) {
    const Setting setting(scene);
    for (const int tile_row : {2, 9, 15}) {
      const RayPacket packet = setting.packet(tile_row, 5 + tile_row);
      std::array<Hit, kLanes> hits;
      setting.world.closest(setting.origin(), packet, true, hits.data());
      for (std::size_t i = 0; i < kLanes; i += 5) {
        const ReferenceRay ray = ray_of(setting, packet, i);
        const double nearest = nearest_of_all(setting.world.scene(), ray);
        ASSERT_EQ(hits[i].empty(), std::isinf(nearest)) << scene;
        if (hits[i].empty()) continue;
        const double found = reference_distance(setting.world.scene(), hits[i], ray);
        ASSERT_NEAR(found, nearest, 1e-4 * nearest) << scene;
      }
    }
  }
}

}  // namespace
}  // namespace imslam::simulation
