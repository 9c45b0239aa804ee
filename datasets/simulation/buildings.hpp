#pragma once

#include <vector>

#include "datasets/simulation/scene.hpp"

namespace imslam::simulation {

struct BuildingPaints {
  std::vector<Paint> facades;
  std::vector<Paint> walls;
  std::vector<Paint> doors;    ///< one tile per face
  std::vector<Paint> windows;  ///< shop windows, one tile per face
  std::vector<Paint> signs;    ///< one tile per face
  std::vector<Paint> metal;
};

BuildingPaints building_paints(Scene& scene, TextureBank& bank, Random& random);

/// A house whose front stands in the pose's y-z plane and looks along -x; `width` along y, centred.
void add_building(
    Mesh& mesh, const lie::SE3d& pose, double width, const BuildingPaints& paints, Random& random);

/// Tall blocks in a ring, to close the view down the streets.
void add_skyline(Mesh& mesh, double radius, const BuildingPaints& paints, Random& random);

/// A lamp post, traffic sign, bin or kiosk at the pose's origin, at most 0.5 m around it.
void add_street_furniture(Mesh& mesh,
                          const lie::SE3d& pose,
                          const BuildingPaints& paints,
                          Random& random);

}  // namespace imslam::simulation
