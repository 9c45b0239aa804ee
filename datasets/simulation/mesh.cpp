#include "datasets/simulation/mesh.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

namespace imslam::simulation {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;

int cells(double length, double cell_m) {
  return std::clamp(static_cast<int>(std::lround(length / cell_m)), 1, 400);
}

}  // namespace

std::uint32_t Mesh::add_vertex(const Vector3d& position, const Vector2d& uv) {
  vertices.push_back({position.cast<float>(), uv.cast<float>(), 1.0F});
  return static_cast<std::uint32_t>(vertices.size() - 1);
}

void Mesh::add_triangle(std::uint32_t a, std::uint32_t b, std::uint32_t c, const Paint& paint) {
  triangles.push_back({a, b, c, surface_count, paint.texture});
}

void Mesh::connect_grid(std::uint32_t first, int columns, int rows, const Paint& paint) {
  const auto stride = static_cast<std::uint32_t>(columns + 1);
  for (int row = 0; row < rows; ++row) {
    for (int column = 0; column < columns; ++column) {
      const std::uint32_t corner =
          first + static_cast<std::uint32_t>(row) * stride + static_cast<std::uint32_t>(column);
      add_triangle(corner, corner + 1, corner + stride + 1, paint);
      add_triangle(corner, corner + stride + 1, corner + stride, paint);
    }
  }
}

void Mesh::add_quad(const Vector3d& corner,
                    const Vector3d& u,
                    const Vector3d& v,
                    const Paint& paint,
                    double cell_m) {
  const int columns = cells(u.norm(), cell_m);
  const int rows = cells(v.norm(), cell_m);
  Vector2d tiles(1.0, 1.0);
  if (paint.tile_m > 0.0F) tiles = Vector2d(u.norm(), v.norm()) / paint.tile_m;
  const auto first = static_cast<std::uint32_t>(vertices.size());
  for (int row = 0; row <= rows; ++row) {
    for (int column = 0; column <= columns; ++column) {
      const double s = static_cast<double>(column) / columns;
      const double t = static_cast<double>(row) / rows;
      // Rows of a texture run downwards, v mostly upwards: keep writing readable.
      const Vector2d uv(s * tiles.x(), (1.0 - t) * tiles.y());
      add_vertex(corner + s * u + t * v, paint.offset.cast<double>() + uv);
    }
  }
  connect_grid(first, columns, rows, paint);
  ++surface_count;
}

void Mesh::add_patch(const Vector3d& a,
                     const Vector3d& b,
                     const Vector3d& c,
                     const Vector3d& d,
                     const Paint& paint) {
  const Vector2d corner = paint.offset.cast<double>();
  const std::uint32_t first = add_vertex(a, corner + Vector2d(0, 1));
  add_vertex(b, corner + Vector2d(1, 1));
  add_vertex(d, corner);
  add_vertex(c, corner + Vector2d(1, 0));
  connect_grid(first, 1, 1, paint);
  ++surface_count;
}

void Mesh::add_box(const lie::SE3d& T_mesh_box,
                   const Vector3d& size,
                   const Paint& paint,
                   bool bottom,
                   double cell_m) {
  const Vector3d h = 0.5 * size;
  const auto face = [&](const Vector3d& corner, const Vector3d& u, const Vector3d& v) {
    const lie::SO3d& R = T_mesh_box.rotation();
    add_quad(T_mesh_box * corner, R * u, R * v, paint, cell_m);
  };
  const Vector3d x(size.x(), 0, 0);
  const Vector3d y(0, size.y(), 0);
  const Vector3d z(0, 0, size.z());
  face({-h.x(), -h.y(), -h.z()}, x, z);
  face({h.x(), h.y(), -h.z()}, -x, z);
  face({h.x(), -h.y(), -h.z()}, y, z);
  face({-h.x(), h.y(), -h.z()}, -y, z);
  face({-h.x(), -h.y(), h.z()}, x, y);
  if (bottom) face({-h.x(), h.y(), -h.z()}, x, -y);
}

void Mesh::add_tube(const Vector3d& from,
                    const Vector3d& to,
                    double radius_from,
                    double radius_to,
                    int sides,
                    const Paint& paint,
                    double cell_m) {
  const Vector3d axis = (to - from).normalized();
  const Vector3d across = axis.unitOrthogonal();
  const Vector3d other = axis.cross(across);
  const double length = (to - from).norm();
  const int rows = cells(length, cell_m);
  // A whole number of tiles around, so that the seam does not show.
  const double tile = paint.tile_m > 0.0F ? paint.tile_m : 1.0;
  const double around = std::max(1.0, std::round(2.0 * M_PI * radius_from / tile));
  const auto first = static_cast<std::uint32_t>(vertices.size());
  for (int row = 0; row <= rows; ++row) {
    const double t = static_cast<double>(row) / rows;
    const double radius = radius_from + t * (radius_to - radius_from);
    for (int side = 0; side <= sides; ++side) {
      const double angle = 2.0 * M_PI * side / sides;
      const Vector3d position =
          from + t * (to - from) + radius * (std::cos(angle) * across + std::sin(angle) * other);
      add_vertex(position,
                 paint.offset.cast<double>() + Vector2d(around * side / sides, -t * length / tile));
    }
  }
  connect_grid(first, sides, rows, paint);
  ++surface_count;
}

void Mesh::add_blob(const Vector3d& centre,
                    const Vector3d& radii,
                    double roughness,
                    Random& random,
                    const Paint& paint) {
  constexpr int kColumns = 18;
  constexpr int kRows = 11;
  // A few random waves make the lumps; they fit around the seam because they are functions of the
  // direction.
  Eigen::Matrix<double, 3, 6> waves;
  for (int k = 0; k < waves.cols(); ++k) waves.col(k) = (1.5 + k) * random.normal3();
  const double tile = paint.tile_m > 0.0F ? paint.tile_m : 1.0;
  const double around = std::max(1.0, std::round(2.0 * M_PI * radii.head<2>().mean() / tile));
  const auto first = static_cast<std::uint32_t>(vertices.size());
  for (int row = 0; row <= kRows; ++row) {
    const double polar = M_PI * (1.0 - static_cast<double>(row) / kRows);
    for (int column = 0; column <= kColumns; ++column) {
      const double azimuth = 2.0 * M_PI * (column % kColumns) / kColumns;
      const Vector3d n(std::sin(polar) * std::cos(azimuth), std::sin(polar) * std::sin(azimuth),
                       std::cos(polar));
      double bump = 0.0;
      for (int k = 0; k < waves.cols(); ++k) bump += std::sin(waves.col(k).dot(n) + k) / (1.0 + k);
      const Vector3d position = centre + (1.0 + roughness * bump) * radii.cwiseProduct(n);
      add_vertex(position, paint.offset.cast<double>() +
                               Vector2d(around * column / kColumns, polar * radii.z() / tile));
    }
  }
  connect_grid(first, kColumns, kRows, paint);
  ++surface_count;
}

void Mesh::add_terrain(const Vector2d& low,
                       const Vector2d& high,
                       double cell_m,
                       const std::function<double(double, double)>& height,
                       const Paint& paint) {
  const int columns = cells(high.x() - low.x(), cell_m);
  const int rows = cells(high.y() - low.y(), cell_m);
  const auto first = static_cast<std::uint32_t>(vertices.size());
  for (int row = 0; row <= rows; ++row) {
    for (int column = 0; column <= columns; ++column) {
      const double x = low.x() + (high.x() - low.x()) * column / columns;
      const double y = low.y() + (high.y() - low.y()) * row / rows;
      add_vertex({x, y, height(x, y)}, Vector2d(x, -y) / paint.tile_m);
    }
  }
  connect_grid(first, columns, rows, paint);
  ++surface_count;
}

void Mesh::add_leaf(const Vector3d& root,
                    const Vector3d& tip,
                    const Vector3d& side,
                    const Paint& paint) {
  const Vector3d middle = 0.5 * (root + tip);
  const Vector2d uv = paint.offset.cast<double>();
  const double reach = 0.12;  // of the tile that one leaf shows
  const std::uint32_t a = add_vertex(root, uv);
  const std::uint32_t b = add_vertex(middle + side, uv + Vector2d(reach, 0.5 * reach));
  const std::uint32_t c = add_vertex(tip, uv + Vector2d(0.0, reach));
  const std::uint32_t d = add_vertex(middle - side, uv + Vector2d(-reach, 0.5 * reach));
  add_triangle(a, b, c, paint);
  add_triangle(a, c, d, paint);
  ++surface_count;
}

lie::SE3d upright(double x, double y, double z, double yaw) {
  return lie::SE3d(lie::SO3d::exp({0, 0, yaw}), {x, y, z});
}

}  // namespace imslam::simulation
