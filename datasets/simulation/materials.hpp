#pragma once

#include "datasets/simulation/texture.hpp"
#include "slam/base/random.hpp"

namespace imslam::simulation {

/// What a surface is made of; each names a family of textures.
enum class Material {
  kPlaster,
  kBrick,
  kPlanks,
  kTiles,
  kCarpet,
  kConcrete,
  kAsphalt,
  kBark,
  kGround,
  kGrass,
  kLeaf,
  kRock,
  kFacade,
  kPoster,
  kBooks,
  kDoor,
  kCeiling,
  kFabric,
  kMetal,
  kCar,
  kGlass,
  kSign,
  kSky,
};

/// Draws a fresh sample of the material, made of noise and geometry only: the same on every
/// machine.
Texture draw_material(Material material, Random random);

}  // namespace imslam::simulation
