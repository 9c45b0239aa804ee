#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <functional>
#include <vector>

#include "datasets/simulation/mesh.hpp"
#include "datasets/simulation/options.hpp"
#include "datasets/simulation/texture_bank.hpp"
#include "slam/base/random.hpp"
#include "slam/lie/se3.hpp"

namespace imslam::simulation {

struct Lamp {
  Eigen::Vector3f position;  ///< [m]
  float power = 1.0F;        ///< light at 1 m distance
};

struct Lighting {
  float ambient = 0.5F;
  float sun = 0.0F;
  Eigen::Vector3f to_sun = Eigen::Vector3f::UnitZ();
  std::vector<Lamp> lamps;
  float ambient_reach_m = 2.0F;  ///< how far away things still shade each other
};

/// One placing of a prototype mesh.
struct Instance {
  std::size_t prototype = 0;
  lie::SE3d T_world_object;
  double scale = 1.0;
  std::function<lie::SE3d(double)> motion;  ///< T_world_object at a time [s]; empty: at rest
};

/// A world to look at and a way to travel through it.
///
/// World: z up, ground near z = 0. `path` gives the body's pose as a function of the travelling
/// time [s] (time at the family's usual speed); it keeps clear of all geometry and has no end.
struct Scene {
  std::vector<Texture> textures;
  Mesh fixed;
  std::vector<Mesh> prototypes;
  std::vector<Instance> instances;
  Lighting lighting;
  std::size_t sky_texture = 0;
  std::function<lie::SE3d(double)> path;

  /// Adds a texture and gives the paint that uses it.
  Paint paint(TextureBank& bank, Material material, double tile_m, Random& random);
};

/// Builds the family that options.scene names.
Scene make_scene(const SimulationOptions& options, TextureBank& bank, const Random& random);

Scene make_room(TextureBank& bank, Random random);
Scene make_corridor(TextureBank& bank, Random random);
Scene make_forest(TextureBank& bank, Random random);
/// `travel_time`: clock time -> time along the path, so that traffic keeps its distance to the
/// camera; empty: nothing drives.
Scene make_street(TextureBank& bank,
                  Random random,
                  const std::function<double(double)>& travel_time);

}  // namespace imslam::simulation
