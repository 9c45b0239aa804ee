#pragma once

#include "slam/training/layer_renderer.hpp"
#include "slam/training/layered_scene.hpp"
#include "slam/training/shape_bank.hpp"
#include "slam/training/triplet.hpp"

namespace imslam::training {

/// A rendered view and the geometry that it was rendered from.
struct SeenScene {
  LayerImages images;
  LayerView view;
};

/// Exact displacements and match states of the pixels of left0, from the planes' equations in
/// double precision (stored as float).
///
///   disparity = fx baseline (inverse depth),   left1 pixel ~ K (R + t plane^T) K^-1 left0 pixel
///
/// A pixel is hidden where another layer is nearer at its exact place in the other view.
void write_disparity(const LayeredScene& scene,
                     const ShapeBank& shapes,
                     const SeenScene& left0,
                     const SeenScene& right0,
                     Triplet& triplet);
void write_flow(const LayeredScene& scene,
                const ShapeBank& shapes,
                const SeenScene& left0,
                const SeenScene& left1,
                Triplet& triplet);

}  // namespace imslam::training
