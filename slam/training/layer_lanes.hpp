#pragma once

#include <cstring>
#include <vector>

#include "datasets/simulation/lanes.hpp"
#include "datasets/simulation/texture_pool.hpp"
#include "slam/training/layer.hpp"
#include "slam/training/shape_bank.hpp"

// Vectors are passed by reference only, so their calling convention does not matter.
#pragma GCC diagnostic push
#pragma GCC diagnostic ignored "-Wpsabi"

// Sixteen image points at once, each looking at a layer of its own.
namespace imslam::training {

using simulation::Floats;
using simulation::Ints;
using simulation::kLanes;

/// Sixteen points of an image [px] and the box around them.
struct ImagePoints {
  Floats x, y;
  float left = 0.0F, right = 0.0F, top = 0.0F, bottom = 0.0F;
};

/// value . [x y 1]
struct PixelCovector {
  float x = 0.0F, y = 0.0F, constant = 0.0F;
};

/// A LayerImage and its Layer, packed for the renderer.
struct PackedLayer {
  PixelCovector inverse_depth, s, t, tile_u, tile_v;
  float left, right, top, bottom;
  float gain, offset;
  const std::uint8_t* shape;  ///< null: endless
  std::size_t texture;
};

/// The layers that sixteen points look at.
struct LayerLanes {
  struct Covectors {
    Floats x, y, constant;
  };
  Covectors inverse_depth, tile_u, tile_v;
  Floats gain, offset;
  simulation::TextureLanes textures;
};

std::vector<PackedLayer> pack_layers(const std::vector<Layer>& layers,
                                     const std::vector<LayerImage>& images,
                                     const ShapeBank& shapes);

/// The nearest layer at each point; the last one where there is none.
void find_nearest(const std::vector<PackedLayer>& layers, const ImagePoints& points, Ints& nearest);

/// Makes all lanes look at the layers numbered `which`.
void aim(const std::vector<PackedLayer>& layers,
         const simulation::TexturePool& pool,
         const Ints& which,
         LayerLanes& lanes);

/// Grey values [0, 255] at the points.
void shade(const LayerLanes& lanes,
           const simulation::TexturePool& pool,
           const ImagePoints& points,
           float softness,
           Floats& grey);

}  // namespace imslam::training

#pragma GCC diagnostic pop
