#pragma once

#include <Eigen/Core>
#include <vector>

#include "datasets/simulation/ray_tracer.hpp"
#include "datasets/simulation/scene.hpp"

namespace imslam::simulation {

/// A texture in doubles, one texel at a time: what TexturePool::sample must match.
class ReferenceTexture {
 public:
  explicit ReferenceTexture(const Texture& texture);

  /// In [0, 1], bilinear within and linear between levels; lod 0 is the finest level.
  double sample(double u, double v, double lod) const;

  int size() const { return static_cast<int>(levels_.front().size()); }

 private:
  using Level = std::vector<std::vector<int>>;  ///< rows of grey levels

  double bilinear(const Level& level, double u, double v) const;

  std::vector<Level> levels_;
};

/// One ray in the world's frame and how it changes from pixel to pixel.
struct ReferenceRay {
  Eigen::Vector3d origin;
  Eigen::Vector3d direction;  ///< unit
  Eigen::Vector3d d_column;
  Eigen::Vector3d d_row;
};

struct ReferenceLook {
  double radiance = 0.0;
  double distance = 0.0;  ///< [m]; sky: inf
};

/// Distance [m] along the ray to the plane of a hit triangle, from its corners in the world.
double reference_distance(const Scene& scene, const Hit& hit, const ReferenceRay& ray);

/// Renders one ray at a time, in doubles, from the corners of the hit triangle: what World::look
/// must match. Things stand where the scene puts them first.
class ReferenceShading {
 public:
  explicit ReferenceShading(const Scene& scene);

  /// `footprint` as in World::look.
  ReferenceLook look(const ReferenceRay& ray, const Hit& hit, double footprint) const;

 private:
  ReferenceLook look_at_sky(const ReferenceRay& ray, double footprint) const;

  const Scene& scene_;
  std::vector<ReferenceTexture> textures_;
};

}  // namespace imslam::simulation
