#pragma once

#include "datasets/simulation/ray_tracer.hpp"
#include "datasets/simulation/scene.hpp"
#include "slam/base/random.hpp"

namespace imslam::simulation {

/// Computes how much light falls on every vertex and stores it in the meshes.
///
/// Fixed mesh: ambient light dimmed by what stands around, sun and lamps with their shadows.
/// Prototypes: only the dimming by their own parts; sun is added where they are placed.
void bake_light(Scene& scene, const RayTracer& tracer, const Random& random);

}  // namespace imslam::simulation
