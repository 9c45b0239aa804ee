#pragma once

#include <vector>

#include "slam/training/triplet.hpp"

namespace imslam::training {

/// A plain rectangle in front of everything that moves on its own, parallel to the image.
///
///   left0 [x, x + width] x [y, y + height],  right0: moved by (-disparity, 0),
///   left1: moved by (flow_u, flow_v)
struct Occluder {
  double x = 0.0, y = 0.0;           ///< upper left corner in left0 [px]
  double width = 0.0, height = 0.0;  ///< [px]
  double disparity = 0.0;            ///< [px], positive
  double flow_u = 0.0, flow_v = 0.0;
  float grey = 0.0F;
};

/// Draws the occluders into the three views, later ones over earlier ones, border pixels by the
/// covered area, and keeps the truth exact: pixels of left0 whose centre is covered get the
/// occluder's displacement; pixels that are covered in another view become hidden there.
void add_occluders(const std::vector<Occluder>& occluders, Triplet& triplet);

}  // namespace imslam::training
