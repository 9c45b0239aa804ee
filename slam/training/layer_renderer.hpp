#pragma once

#include <cstdint>
#include <vector>

#include "datasets/simulation/texture_pool.hpp"
#include "slam/training/layered_scene.hpp"
#include "slam/training/shape_bank.hpp"

namespace imslam::training {

/// The layers of a scene as one camera sees them, in the order of the scene.
using LayerImages = std::vector<LayerImage>;

/// What a camera sees. Row major, width * height.
struct LayerView {
  std::vector<float> grey;          ///< [0, 255]
  std::vector<std::int32_t> layer;  ///< the nearest at the pixel's centre
};

/// Renders by inverse mapping: a pixel looks for the nearest layer at its centre and averages that
/// layer's texture over its footprint (mip levels, a row of taps where it is seen aslant); pixels
/// at edges are means of several such looks.
class LayerRenderer {
 public:
  LayerRenderer(const simulation::TexturePool& pool, const ShapeBank& shapes)
      : pool_(pool), shapes_(shapes) {}

  /// `softness`: mip levels added to every footprint, as a lens that is not quite sharp would.
  void render(const LayeredScene& scene,
              const LayerImages& images,
              float softness,
              LayerView& view) const;

 private:
  const simulation::TexturePool& pool_;
  const ShapeBank& shapes_;
};

}  // namespace imslam::training
