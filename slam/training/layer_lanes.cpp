#include "slam/training/layer_lanes.hpp"

#include <algorithm>

#include "slam/base/error.hpp"

// Vectors are passed by reference only, so their calling convention does not matter.
#pragma GCC diagnostic ignored "-Wpsabi"

namespace imslam::training {
namespace {

using simulation::absolute;
using simulation::all;
using simulation::least;
using simulation::most;
using simulation::to_floats;
using simulation::to_ints;

constexpr int kMostTaps = 6;

PixelCovector packed(const Eigen::Vector3d& f) {
  return {static_cast<float>(f.x()), static_cast<float>(f.y()), static_cast<float>(f.z())};
}

[[gnu::always_inline]] inline Floats at(const PixelCovector& f, const ImagePoints& p) {
  return f.x * p.x + f.y * p.y + f.constant;
}

[[gnu::always_inline]] inline Floats at(const LayerLanes::Covectors& f, const ImagePoints& p) {
  return f.x * p.x + f.y * p.y + f.constant;
}

[[gnu::always_inline]] inline bool any(const Ints& lanes) {
  std::int32_t seen = 0;
  for (std::size_t i = 0; i < kLanes; ++i) seen |= lanes[i];
  return seen != 0;
}

/// ShapeBank::inside() for sixteen points; false where `asked` is.
[[gnu::always_inline]] inline Ints inside(const std::uint8_t* samples,
                                          const Floats& s,
                                          const Floats& t,
                                          const Ints& asked) {
  constexpr int kSize = ShapeBank::kSize;
  constexpr float kHalf = 0.5F * (kSize - 1);
  const Ints within = asked & (absolute(s) < 1.0F) & (absolute(t) < 1.0F);
  if (!any(within)) return within;
  const Floats x = within ? s * kHalf + kHalf : Floats{};
  const Floats y = within ? t * kHalf + kHalf : Floats{};
  Ints column = to_ints(x);
  Ints row = to_ints(y);
  column = column < kSize - 2 ? column : Ints{} + (kSize - 2);
  row = row < kSize - 2 ? row : Ints{} + (kSize - 2);
  const Floats fx = x - to_floats(column);
  const Floats fy = y - to_floats(row);
  const Ints index = row * kSize + column;
  Ints above;
  Ints below;
  for (std::size_t i = 0; i < kLanes; ++i) {
    std::uint16_t pair;
    std::memcpy(&pair, samples + index[i], sizeof pair);
    above[i] = pair;
    std::memcpy(&pair, samples + index[i] + kSize, sizeof pair);
    below[i] = pair;
  }
  const Floats upper_left = to_floats(above & 255);
  const Floats lower_left = to_floats(below & 255);
  const Floats upper = upper_left + fx * (to_floats(above >> 8) - upper_left);
  const Floats lower = lower_left + fx * (to_floats(below >> 8) - lower_left);
  return within & (upper + fy * (lower - upper) >= ShapeBank::kEdge);
}

/// What a pixel covers of its texture: a parallelogram, taken as a row of squares along its longer
/// side.
[[gnu::always_inline]] inline simulation::Footprints footprints(const LayerLanes& lanes,
                                                                const ImagePoints& p,
                                                                float softness) {
  const Floats depth = 1.0F / most(at(lanes.inverse_depth, p), all(1e-9F));
  simulation::Footprints f;
  f.u = at(lanes.tile_u, p) * depth;
  f.v = at(lanes.tile_v, p) * depth;
  const Floats du_x = (lanes.tile_u.x - f.u * lanes.inverse_depth.x) * depth;
  const Floats dv_x = (lanes.tile_v.x - f.v * lanes.inverse_depth.x) * depth;
  const Floats du_y = (lanes.tile_u.y - f.u * lanes.inverse_depth.y) * depth;
  const Floats dv_y = (lanes.tile_v.y - f.v * lanes.inverse_depth.y) * depth;
  const Floats along_x = du_x * du_x + dv_x * dv_x;
  const Floats along_y = du_y * du_y + dv_y * dv_y;
  const Floats longest = most(most(along_x, along_y), all(1e-20F));
  // The parallelogram's width across its longer side, squared, is area^2 / longest.
  const Floats area = du_x * dv_y - dv_x * du_y;
  const Floats across = most(area * area / longest, all(1e-20F));
  f.taps = Ints{} + 1;
  for (int taps = 1; taps < kMostTaps; ++taps) {
    const auto bound = static_cast<float>(taps * taps);
    f.taps -= longest > 1.2F * bound * across;  // a comparison that holds is -1
  }
  const Floats count = to_floats(f.taps);
  f.du = (along_x > along_y ? du_x : du_y) / count;
  f.dv = (along_x > along_y ? dv_x : dv_y) / count;
  const Floats size = to_floats(lanes.textures.size);
  const Floats square = most(longest / (count * count), across);
  f.lod = 0.5F * simulation::fast_log2(square * size * size) + softness;
  f.lod = least(most(f.lod, all(0.0F)), all(20.0F));
  return f;
}

void put(LayerLanes::Covectors& lanes, std::size_t i, const PixelCovector& f) {
  lanes.x[i] = f.x;
  lanes.y[i] = f.y;
  lanes.constant[i] = f.constant;
}

}  // namespace

std::vector<PackedLayer> pack_layers(const std::vector<Layer>& layers,
                                     const std::vector<LayerImage>& images,
                                     const ShapeBank& shapes) {
  expects(layers.size() == images.size(), "pack_layers: an image for each layer");
  std::vector<PackedLayer> result;
  for (std::size_t i = 0; i < layers.size(); ++i) {
    const Layer& layer = layers[i];
    const LayerImage& image = images[i];
    PackedLayer p{};
    p.inverse_depth = packed(image.inverse_depth);
    p.s = packed(image.s);
    p.t = packed(image.t);
    p.tile_u = packed(image.tile_u);
    p.tile_v = packed(image.tile_v);
    p.left = static_cast<float>(image.left) - 0.01F;
    p.right = static_cast<float>(image.right) + 0.01F;
    p.top = static_cast<float>(image.top) - 0.01F;
    p.bottom = static_cast<float>(image.bottom) + 0.01F;
    p.gain = static_cast<float>(layer.gain);
    p.offset = static_cast<float>(layer.offset);
    if (layer.shape != Layer::kEndless)
      p.shape = shapes.samples(static_cast<std::size_t>(layer.shape));
    p.texture = layer.texture;
    result.push_back(p);
  }
  return result;
}

IMSLAM_FOR_EACH_PROCESSOR void find_nearest(const std::vector<PackedLayer>& layers,
                                            const ImagePoints& p,
                                            Ints& nearest) {
  nearest = Ints{} + static_cast<int>(layers.size() - 1);
  Floats most_near = {};
  for (std::size_t l = 0; l < layers.size(); ++l) {
    const PackedLayer& layer = layers[l];
    if (layer.left > p.right || layer.right < p.left) continue;
    if (layer.top > p.bottom || layer.bottom < p.top) continue;
    const Floats inverse_depth = at(layer.inverse_depth, p);
    Ints ahead = inverse_depth > most_near;
    if (!any(ahead)) continue;
    if (layer.shape != nullptr) {
      const Floats divisor = ahead ? inverse_depth : all(1.0F);
      ahead = inside(layer.shape, at(layer.s, p) / divisor, at(layer.t, p) / divisor, ahead);
    }
    most_near = ahead ? inverse_depth : most_near;
    nearest = ahead ? Ints{} + static_cast<int>(l) : nearest;
  }
}

void aim(const std::vector<PackedLayer>& layers,
         const simulation::TexturePool& pool,
         const Ints& which,
         LayerLanes& lanes) {
  for (std::size_t i = 0; i < kLanes; ++i) {
    const PackedLayer& layer = layers[static_cast<std::size_t>(which[i])];
    put(lanes.inverse_depth, i, layer.inverse_depth);
    put(lanes.tile_u, i, layer.tile_u);
    put(lanes.tile_v, i, layer.tile_v);
    lanes.gain[i] = layer.gain;
    lanes.offset[i] = layer.offset;
    pool.aim(layer.texture, i, lanes.textures);
  }
}

IMSLAM_FOR_EACH_PROCESSOR void shade(const LayerLanes& lanes,
                                     const simulation::TexturePool& pool,
                                     const ImagePoints& points,
                                     float softness,
                                     Floats& grey) {
  Floats texture;
  pool.sample(lanes.textures, footprints(lanes, points, softness), texture);
  grey = least(most(255.0F * (lanes.offset + lanes.gain * texture), all(0.0F)), all(255.0F));
}

}  // namespace imslam::training
