#pragma once

#include <cstddef>
#include <vector>

#include "datasets/simulation/scene.hpp"

namespace imslam::simulation {

/// Prototypes of things that grow or lie in a wood, as indices in scene.prototypes. They stand on
/// z = 0 at their origin and are of natural size.
struct Vegetation {
  std::vector<std::size_t> trees;
  std::vector<std::size_t> bushes;
  std::vector<std::size_t> ferns;
  std::vector<std::size_t> stones;
  std::vector<std::size_t> logs;
};

/// Leaves are real geometry: small triangles, so that their outlines and gaps are exact.
Vegetation grow_vegetation(Scene& scene, TextureBank& bank, Random& random);

}  // namespace imslam::simulation
