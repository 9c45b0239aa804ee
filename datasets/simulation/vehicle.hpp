#pragma once

#include <vector>

#include "datasets/simulation/scene.hpp"

namespace imslam::simulation {

inline constexpr double kCarLength = 4.3;  ///< [m] the longest one

/// Cars of different shape and paint as indices in scene.prototypes; x forward, standing on z = 0,
/// origin in the middle.
std::vector<std::size_t> build_cars(Scene& scene, TextureBank& bank, Random& random);

}  // namespace imslam::simulation
