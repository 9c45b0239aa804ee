#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <functional>
#include <vector>

#include "slam/base/random.hpp"
#include "slam/lie/se3.hpp"

namespace imslam::simulation {

struct Vertex {
  Eigen::Vector3f position;  ///< [m]
  Eigen::Vector2f uv;        ///< [tiles]
  float light = 1.0F;        ///< what falls on it; baked later
};

struct Triangle {
  std::uint32_t a = 0;
  std::uint32_t b = 0;
  std::uint32_t c = 0;
  std::uint32_t surface = 0;  ///< smooth piece it belongs to: edges are where this changes
  std::uint32_t texture = 0;  ///< index in the scene's list
};

/// How a surface is papered.
struct Paint {
  std::uint32_t texture = 0;
  float tile_m = 1.0F;                               ///< size of one tile; 0: one tile per face
  Eigen::Vector2f offset = Eigen::Vector2f::Zero();  ///< [tiles]
};

/// Triangles in metres; winding is counter-clockwise seen from outside.
struct Mesh {
  std::vector<Vertex> vertices;
  std::vector<Triangle> triangles;
  std::uint32_t surface_count = 0;

  /// The parallelogram corner + [0,1] u + [0,1] v, facing u x v, cut into cells of about cell_m so
  /// that baked light can vary over it.
  void add_quad(const Eigen::Vector3d& corner,
                const Eigen::Vector3d& u,
                const Eigen::Vector3d& v,
                const Paint& paint,
                double cell_m = 0.3);

  /// The flat or bent piece between four corners, counter-clockwise; papered with one tile.
  void add_patch(const Eigen::Vector3d& a,
                 const Eigen::Vector3d& b,
                 const Eigen::Vector3d& c,
                 const Eigen::Vector3d& d,
                 const Paint& paint);

  /// Box with the given full sizes about the pose's origin; `bottom` = false leaves that face out.
  void add_box(const lie::SE3d& T_mesh_box,
               const Eigen::Vector3d& size,
               const Paint& paint,
               bool bottom = false,
               double cell_m = 0.3);

  /// Open cone or tube between two points.
  void add_tube(const Eigen::Vector3d& from,
                const Eigen::Vector3d& to,
                double radius_from,
                double radius_to,
                int sides,
                const Paint& paint,
                double cell_m = 1.0);

  /// Lumpy ellipsoid, e.g. a stone or a bush.
  void add_blob(const Eigen::Vector3d& centre,
                const Eigen::Vector3d& radii,
                double roughness,
                Random& random,
                const Paint& paint);

  /// Surface z = height(x, y) over a rectangle.
  void add_terrain(const Eigen::Vector2d& low,
                   const Eigen::Vector2d& high,
                   double cell_m,
                   const std::function<double(double, double)>& height,
                   const Paint& paint);

  /// A small two-triangle leaf, bent along its middle.
  void add_leaf(const Eigen::Vector3d& root,
                const Eigen::Vector3d& tip,
                const Eigen::Vector3d& side,
                const Paint& paint);

 private:
  std::uint32_t add_vertex(const Eigen::Vector3d& position, const Eigen::Vector2d& uv);
  void add_triangle(std::uint32_t a, std::uint32_t b, std::uint32_t c, const Paint& paint);
  /// Connects a grid of (columns + 1) x (rows + 1) vertices that starts at `first`.
  void connect_grid(std::uint32_t first, int columns, int rows, const Paint& paint);
};

/// A pose standing upright: position and heading.
lie::SE3d upright(double x, double y, double z, double yaw);

}  // namespace imslam::simulation
