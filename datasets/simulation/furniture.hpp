#pragma once

#include <vector>

#include "datasets/simulation/scene.hpp"

namespace imslam::simulation {

/// Papers for things that stand in rooms, drawn once per scene.
struct FurniturePaints {
  std::vector<Paint> wood;
  std::vector<Paint> cloth;
  std::vector<Paint> metal;
  std::vector<Paint> pictures;  ///< one tile per face
  std::vector<Paint> books;     ///< one tile per face
  std::vector<Paint> leaves;
};

FurniturePaints furniture_paints(Scene& scene, TextureBank& bank, Random& random);

/// Pieces stand on z = 0 at the pose's origin with their backs towards -x of the pose; depth along
/// x, width along y. Each stays within depth x width.
void add_bookshelf(Mesh& mesh,
                   const lie::SE3d& pose,
                   const FurniturePaints& paints,
                   Random& random);
void add_cabinet(Mesh& mesh, const lie::SE3d& pose, const FurniturePaints& paints, Random& random);
void add_table(Mesh& mesh, const lie::SE3d& pose, const FurniturePaints& paints, Random& random);
void add_sofa(Mesh& mesh, const lie::SE3d& pose, const FurniturePaints& paints, Random& random);
void add_boxes(Mesh& mesh, const lie::SE3d& pose, const FurniturePaints& paints, Random& random);
void add_plant(Mesh& mesh, const lie::SE3d& pose, const FurniturePaints& paints, Random& random);

/// A picture with a frame on a wall: the pose's x points out of the wall.
void add_picture(Mesh& mesh,
                 const lie::SE3d& pose,
                 double width,
                 double height,
                 const FurniturePaints& paints,
                 Random& random);

/// One of the list, by chance.
const Paint& any(const std::vector<Paint>& paints, Random& random);

}  // namespace imslam::simulation
