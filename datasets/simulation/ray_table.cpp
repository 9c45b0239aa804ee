#include "datasets/simulation/ray_table.hpp"

#include <Eigen/LU>
#include <algorithm>

#include "slam/base/parallel.hpp"

// Vectors are passed by reference only, so their calling convention does not matter.
#pragma GCC diagnostic ignored "-Wpsabi"

namespace imslam::simulation {
namespace {

/// Pseudo-inverse of [d_column d_row].
Eigen::Matrix<double, 2, 3> inverse_of_steps(const Eigen::Vector3d& d_column,
                                             const Eigen::Vector3d& d_row) {
  Eigen::Matrix<double, 3, 2> J_direction_pixel;
  J_direction_pixel << d_column, d_row;
  const Eigen::Matrix2d normal = J_direction_pixel.transpose() * J_direction_pixel;
  if (normal.determinant() < 1e-24) return Eigen::Matrix<double, 2, 3>::Zero();
  return normal.inverse() * J_direction_pixel.transpose();
}

[[gnu::always_inline]] inline Floats3 rotated(const Eigen::Matrix3f& R, const Floats3& a) {
  return {R(0, 0) * a.x + R(0, 1) * a.y + R(0, 2) * a.z,
          R(1, 0) * a.x + R(1, 1) * a.y + R(1, 2) * a.z,
          R(2, 0) * a.x + R(2, 1) * a.y + R(2, 2) * a.z};
}

void put(Floats3& lanes, std::size_t lane, const Eigen::Vector3d& value) {
  lanes.x[lane] = static_cast<float>(value.x());
  lanes.y[lane] = static_cast<float>(value.y());
  lanes.z[lane] = static_cast<float>(value.z());
}

Eigen::Vector3f taken(const Floats3& lanes, std::size_t lane) {
  return {lanes.x[lane], lanes.y[lane], lanes.z[lane]};
}

}  // namespace

RayTable::RayTable(const Lens& lens) : width_(lens.width()), height_(lens.height()) {
  // A pixel beyond the border is needed for the change from one to the next.
  const auto stride = static_cast<std::size_t>(width_ + 2);
  std::vector<Eigen::Vector3d> wide(static_cast<std::size_t>(height_ + 2) * stride);
  parallel_for(static_cast<std::size_t>(height_ + 2), [&](std::size_t row) {
    for (std::size_t column = 0; column < stride; ++column) {
      wide[row * stride + column] = lens.direction(
          Eigen::Vector2d(static_cast<double>(column) - 1.0, static_cast<double>(row) - 1.0));
    }
  });
  const auto at = [&](int row, int column) {
    return &wide[static_cast<std::size_t>(row + 1) * stride + static_cast<std::size_t>(column + 1)];
  };
  for (int row = 0; row < height_; ++row) {
    directions_.insert(directions_.end(), at(row, 0), at(row, width_));
  }
  tiles_.resize(static_cast<std::size_t>(tile_rows() * tile_columns()));
  pixel_changes_.resize(tiles_.size());
  parallel_for(tiles_.size(), [&](std::size_t i) {
    const int first_row = static_cast<int>(i) / tile_columns() * kTile;
    const int first_column = static_cast<int>(i) % tile_columns() * kTile;
    for (std::size_t lane = 0; lane < kLanes; ++lane) {
      const int row = std::min(first_row + static_cast<int>(lane) / kTile, height_ - 1);
      const int column = std::min(first_column + static_cast<int>(lane) % kTile, width_ - 1);
      const Eigen::Vector3d* here = at(row, column);
      const Eigen::Vector3d d_column = 0.5 * (here[1] - here[-1]);
      const Eigen::Vector3d d_row = 0.5 * (*at(row + 1, column) - *at(row - 1, column));
      put(tiles_[i].direction, lane, *here);
      put(tiles_[i].d_column, lane, d_column);
      put(tiles_[i].d_row, lane, d_row);
      const Eigen::Matrix<double, 2, 3> J = inverse_of_steps(d_column, d_row);
      put(pixel_changes_[i].column, lane, J.row(0).transpose());
      put(pixel_changes_[i].row, lane, J.row(1).transpose());
    }
  });
}

IMSLAM_FOR_EACH_PROCESSOR RayPacket RayTable::tile_packet(const Eigen::Matrix3f& R_world_camera,
                                                          int tile_row,
                                                          int tile_column) const {
  const Tile& rays = tile(tile_row, tile_column);
  RayPacket packet;
  packet.direction = rotated(R_world_camera, rays.direction);
  packet.d_column = rotated(R_world_camera, rays.d_column);
  packet.d_row = rotated(R_world_camera, rays.d_row);
  packet.count = kLanes;
  return packet;
}

void RayTable::add_pixel(const Eigen::Matrix3f& R_world_camera,
                         int row,
                         int column,
                         RayPacket& packet) const {
  const Tile& rays = tile(row / kTile, column / kTile);
  const auto from = static_cast<std::size_t>(row % kTile * kTile + column % kTile);
  const std::size_t to = packet.count++;
  const auto turned = [&](const Floats3& lanes) {
    return (R_world_camera * taken(lanes, from)).cast<double>().eval();
  };
  put(packet.direction, to, turned(rays.direction));
  put(packet.d_column, to, turned(rays.d_column));
  put(packet.d_row, to, turned(rays.d_row));
}

}  // namespace imslam::simulation
