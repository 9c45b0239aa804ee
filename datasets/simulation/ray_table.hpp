#pragma once

#include <Eigen/Core>
#include <vector>

#include "datasets/simulation/lens.hpp"
#include "datasets/simulation/packet.hpp"

namespace imslam::simulation {

/// The rays of all pixels of a lens, computed once.
class RayTable {
 public:
  static constexpr int kTile = 4;  ///< a tile is a square of kTile x kTile pixels, one packet

  explicit RayTable(const Lens& lens);

  int width() const { return width_; }
  int height() const { return height_; }

  /// Unit direction in the camera frame.
  const Eigen::Vector3d& direction(int row, int column) const {
    return directions_[static_cast<std::size_t>(row * width_ + column)];
  }
  /// Rays of one tile in the camera frame, row by row. At the right and lower border the tile may
  /// stick out of the image; those lanes hold some rays.
  struct Tile {
    Floats3 direction;  ///< unit
    Floats3 d_column;   ///< change per pixel to the right
    Floats3 d_row;      ///< change per pixel downwards
  };
  /// Change of a tile's pixels [px] per change of the (not necessarily unit) direction; blind to
  /// changes along the ray.
  struct PixelChange {
    Floats3 column;
    Floats3 row;
  };
  const Tile& tile(int tile_row, int tile_column) const {
    return tiles_[tile_index(tile_row, tile_column)];
  }
  const PixelChange& pixel_change(int tile_row, int tile_column) const {
    return pixel_changes_[tile_index(tile_row, tile_column)];
  }
  int tile_rows() const { return (height_ + kTile - 1) / kTile; }
  int tile_columns() const { return (width_ + kTile - 1) / kTile; }

  /// All rays of a tile in the world's frame.
  RayPacket tile_packet(const Eigen::Matrix3f& R_world_camera, int tile_row, int tile_column) const;

  /// Appends one pixel's ray to a packet that is not full.
  void add_pixel(const Eigen::Matrix3f& R_world_camera,
                 int row,
                 int column,
                 RayPacket& packet) const;

 private:
  std::size_t tile_index(int tile_row, int tile_column) const {
    return static_cast<std::size_t>(tile_row * tile_columns() + tile_column);
  }

  int width_;
  int height_;
  std::vector<Eigen::Vector3d> directions_;
  std::vector<Tile> tiles_;
  std::vector<PixelChange> pixel_changes_;
};

}  // namespace imslam::simulation
