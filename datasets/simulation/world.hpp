#pragma once

#include <Eigen/Core>
#include <vector>

#include "datasets/simulation/ray_tracer.hpp"
#include "datasets/simulation/scene.hpp"
#include "datasets/simulation/texture_pool.hpp"

namespace imslam::simulation {

/// A triangle as a plane with what varies linearly over it, in the mesh's frame:
///   u = u0 + grad_u . (p - origin), v and light alike.
struct Facet {
  Eigen::Vector3f origin = Eigen::Vector3f::Zero();
  Eigen::Vector3f normal = Eigen::Vector3f::UnitZ();
  Eigen::Vector3f grad_u = Eigen::Vector3f::Zero();
  Eigen::Vector3f grad_v = Eigen::Vector3f::Zero();
  Eigen::Vector3f grad_light = Eigen::Vector3f::Zero();
  float u0 = 0.0F;
  float v0 = 0.0F;
  float light0 = 0.0F;
  std::uint32_t texture = 0;
  std::uint32_t surface = 0;
};

/// A scene at an instant: traces and shades rays.
class World {
 public:
  World(Scene scene, const Random& random);

  /// Moves the moving things to where they are at `time_s`.
  void set_time(double time_s);

  void closest(const Eigen::Vector3f& origin,
               const RayPacket& rays,
               bool coherent,
               Hit* hits) const {
    tracer_.closest(origin, rays, coherent, hits);
  }
  bool occluded(const Eigen::Vector3f& origin, const Eigen::Vector3f& to, float share) const {
    return tracer_.occluded(origin, to - origin, share);
  }

  /// `footprint`: size of the sampled area in pixels, 1 for a whole pixel. Lanes beyond rays.count
  /// get values without a meaning.
  void look(const Eigen::Vector3f& origin,
            const RayPacket& rays,
            const Hit* hits,
            float footprint,
            SeenPacket& seen) const;

  /// Motion that carries a point of an instance from where it is at t0 to where it is at t1.
  lie::SE3d instance_motion(std::uint32_t instance, double t0, double t1) const;
  bool moves(std::uint32_t instance) const {
    return instance > 0 && static_cast<bool>(scene_.instances[instance - 1].motion);
  }
  bool anything_moves() const { return anything_moves_; }

  const Scene& scene() const { return scene_; }

 private:
  struct Placement {
    Eigen::Matrix3f R_world_object;
    Eigen::Vector3f position;
    float scale = 1.0F;
    std::size_t mesh = 0;  ///< index in facets_
  };

  void place(std::size_t instance, const lie::SE3d& T_world_object);

  Scene scene_;
  TexturePool pool_;
  RayTracer tracer_;
  std::vector<std::vector<Facet>> facets_;  ///< fixed mesh first, then the prototypes
  std::vector<Placement> placements_;       ///< fixed mesh first, then the instances
  bool anything_moves_ = false;
};

}  // namespace imslam::simulation
