#pragma once

#include <Eigen/Core>
#include <optional>
#include <vector>

#include "slam/base/random.hpp"

namespace imslam::training {

/// Where a ray from the camera, at the origin, meets the scene.
struct SceneHit {
  double distance = 0.0;  ///< along the ray, in its lengths
  int object = -1;        ///< which of the movable things; -1: what stands still
};

/// A world of planes, rectangles and balls around the first camera, in its own units of length;
/// axes as a level camera's: x right, y down, z forward.
class FlowScene {
 public:
  enum class Kind { kRoom, kStreet, kGround, kClutter, kRelief };

  FlowScene(Kind kind, Random& random);

  /// Nearest thing along the ray; none: sky.
  std::optional<SceneHit> cast(const Eigen::Vector3d& ray) const;

  int object_count() const { return object_count_; }

 private:
  /// Points X with normal . X = offset, within the rectangle if it has half sizes.
  struct Plane {
    Eigen::Vector3d normal;
    double offset = 0.0;
    Eigen::Vector3d centre = Eigen::Vector3d::Zero();
    Eigen::Vector3d across = Eigen::Vector3d::Zero();  ///< unit, in the plane
    double half_across = 0.0;                          ///< 0: without bounds
    double half_along = 0.0;
    int object = -1;
  };
  struct Ball {
    Eigen::Vector3d centre;
    double radius = 0.0;
    int object = -1;
  };

  void add_wall(const Eigen::Vector3d& normal, double offset);
  void add_room(Random& random);
  void add_street(Random& random);
  void add_ground(Random& random);
  void add_relief(Random& random);
  void add_objects(int count, double nearest, double farthest, Random& random);

  std::vector<Plane> planes_;
  std::vector<Ball> balls_;
  /// Relief: depth = depth_ exp(sum amplitude sin(frequency . (x/z, y/z) + phase)).
  double depth_ = 0.0;                  ///< 0: none
  std::vector<Eigen::Vector4d> waves_;  ///< amplitude, frequency x, y, phase
  int object_count_ = 0;
};

}  // namespace imslam::training
