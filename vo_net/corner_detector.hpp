#pragma once

#include <Eigen/Core>
#include <vector>

#include "vo_net/image_pyramid.hpp"

namespace imslam::vo {

struct CornerOptions {
  int max_points = 800;      ///< cells of the grid: at most one point in each
  int block = 5;             ///< [px at half size] side of the structure tensor's window
  double min_quality = 0.0;  ///< [grey^2/px^2] smallest eigenvalue that counts
  int margin = 12;           ///< [px] from the image border
  bool fill_cells = false;   ///< a cell without a corner gives its centre
};

/// Picks the best corner (smaller eigenvalue of the structure tensor) of every cell of a regular
/// grid that holds none of the `taken` points. Works at half size: where exactly a point lies is
/// free, it only has to be well textured.
///
/// `cell` [px] is the side of a cell. Returns positions at full size, row by row.
std::vector<Eigen::Vector2d> detect_corners(const ImagePyramid& image,
                                            const std::vector<Eigen::Vector2d>& taken,
                                            const CornerOptions& options);

/// Side [px] of the cells that cut a width x height image into about `max_points`.
double cell_side(int width, int height, int max_points);

}  // namespace imslam::vo
