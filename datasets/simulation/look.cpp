#include "datasets/simulation/shading.hpp"
#include "datasets/simulation/world.hpp"

namespace imslam::simulation {
namespace {

using Eigen::Vector3f;

constexpr std::uint32_t kSkySurface = 0xFFFFFFFFU;

void put(Floats3& lanes, std::size_t lane, const Vector3f& value) {
  lanes.x[lane] = value.x();
  lanes.y[lane] = value.y();
  lanes.z[lane] = value.z();
}

void put(HitLanes& lanes, std::size_t lane, const Facet& facet) {
  put(lanes.origin, lane, facet.origin);
  put(lanes.normal, lane, facet.normal);
  put(lanes.grad_u, lane, facet.grad_u);
  put(lanes.grad_v, lane, facet.grad_v);
  put(lanes.grad_light, lane, facet.grad_light);
  lanes.u0[lane] = facet.u0;
  lanes.v0[lane] = facet.v0;
  lanes.light0[lane] = facet.light0;
}

/// A number that differs between the surfaces of all instances, as good as always.
std::uint32_t surface_of(std::uint32_t instance, const Facet& facet) {
  return (instance * 0x9E3779B1U) ^ (facet.surface * 0x85EBCA77U);
}

}  // namespace

void World::look(const Vector3f& origin,
                 const RayPacket& rays,
                 const Hit* hits,
                 float footprint,
                 SeenPacket& seen) const {
  static const Facet kNoFacet;
  HitLanes lanes;
  for (std::size_t i = 0; i < kLanes; ++i) {
    const bool sky = i >= rays.count || hits[i].empty();
    const std::uint32_t instance = sky ? 0 : hits[i].instance;
    const Placement& placement = placements_[instance];
    const Facet& facet = sky ? kNoFacet : facets_[placement.mesh][hits[i].triangle];
    put(lanes, i, facet);
    pool_.aim(sky ? scene_.sky_texture : facet.texture, i, lanes.texture);
    put(lanes.from, i, origin - placement.position);
    lanes.scale[i] = placement.scale;
    lanes.sky[i] = sky ? -1 : 0;
    lanes.instanced[i] = instance != 0 ? -1 : 0;
    lanes.any_sky = lanes.any_sky || sky;
    lanes.any_instance = lanes.any_instance || instance != 0;
    seen.surface[i] = sky ? kSkySurface : surface_of(instance, facet);
    seen.instance[i] = instance;
  }
  if (lanes.any_instance) {
    for (std::size_t i = 0; i < kLanes; ++i) {
      const float* R = placements_[seen.instance[i]].R_world_object.data();
      for (std::size_t k = 0; k < 9; ++k) lanes.R_world_object[k][i] = R[k];
    }
  }
  shade(lanes, pool_, scene_.lighting, rays, footprint, seen);
}

}  // namespace imslam::simulation
