#pragma once

#include <cstddef>
#include <vector>

#include "datasets/simulation/scene.hpp"

namespace imslam::simulation {

/// Prototypes of things that grow or lie in a wood, as indices in scene.prototypes. They stand on
/// z = 0 at their origin and are of natural size.
struct Vegetation {
  std::vector<std::size_t> broadleaves;      ///< crown above 2.9 m
  std::vector<std::size_t> conifers;         ///< boughs down to 1.5 m, reaching out 2.5 m
  std::vector<std::size_t> far_broadleaves;  ///< the same kinds with fewer, larger leaves
  std::vector<std::size_t> far_conifers;
  std::vector<std::size_t> bushes;
  std::vector<std::size_t> far_bushes;
  std::vector<std::size_t> ferns;
  std::vector<std::size_t> stones;
  std::vector<std::size_t> logs;
};

/// Leaves are real geometry: small triangles, so that their outlines and gaps are exact.
Vegetation grow_vegetation(Scene& scene, TextureBank& bank, Random& random);

}  // namespace imslam::simulation
