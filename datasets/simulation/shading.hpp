#pragma once

#include "datasets/simulation/packet.hpp"
#include "datasets/simulation/scene.hpp"
#include "datasets/simulation/texture_pool.hpp"

namespace imslam::simulation {

/// What the rays of a packet meet, lane by lane. Where it is the sky, the facet's gradients are 0.
struct HitLanes {
  Floats3 origin, normal, grad_u, grad_v, grad_light;  ///< of the facets, as in Facet
  Floats u0, v0, light0;
  TextureLanes texture;
  Floats R_world_object[9];   ///< column major; not set without any_instance
  Floats3 from;               ///< from the object's origin to the camera [m], world
  Floats scale;               ///< of the object
  Ints sky;                   ///< -1: nothing was hit
  Ints instanced;             ///< -1: hit an instance, else 0
  bool any_sky = false;       ///< some lane sees the sky
  bool any_instance = false;  ///< some lane hit an instance
};

/// Radiance and distance along the rays of a packet; identities are left alone.
///
///   radiance = mean of the texture over the footprint * light   (+ haze before the sky)
///
/// `footprint` as in World::look().
void shade(const HitLanes& hits,
           const TexturePool& pool,
           const Lighting& light,
           const RayPacket& rays,
           float footprint,
           SeenPacket& seen);

}  // namespace imslam::simulation
